"""The forward pass: its sums run over the inputs in order, whatever their number, so that its bits stay."""

import numpy as np
import pytest

from rss_gym.baselines.network import IDENTITY, feed_forward


@pytest.mark.parametrize("inputs", range(1, 11))
def test_sums_run_over_the_inputs_in_order(inputs):
    generator = np.random.default_rng(inputs)
    weight, bias = generator.normal(size=(inputs, 7)), generator.normal(size=7)
    rows, outputs = (
        generator.normal(size=(5, inputs)) * 10.0 ** generator.integers(-8, 8, (5, inputs)),
        np.empty((5, 7)),
    )
    feed_forward((weight,), (bias,), np.array([IDENTITY]), rows, outputs)
    for row, output in zip(rows, outputs, strict=True):
        for j in range(7):
            total = float(bias[j])
            for i in range(inputs):
                total += float(row[i]) * float(weight[i, j])
            assert output[j] == total
