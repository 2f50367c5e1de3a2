"""The forward pass of a learned policy, row by row: the same bits whatever the batch and the machine.

Sums run over the inputs in order, the outputs side by side: the compiler vectorises that without reordering a sum.
Everything is in double precision.
"""

import numpy as np

from rss_gym.jit import inner, kernel
from rss_gym.physics.elementary import tanh

IDENTITY, TANH, RELU = range(3)
ACTIVATIONS: dict[str, int] = {"identity": IDENTITY, "tanh": TANH, "relu": RELU}


@kernel(inline="always")
def sigmoid(x):
    """1 / (1 + e^-x), without overflow."""
    return 0.5 * (1.0 + tanh(0.5 * x))


@inner
def dense(weight, bias, x, y):
    """Y = x W + b for one row; `weight` (inputs, outputs)."""
    inputs = weight.shape[0]
    whole = inputs - inputs % 4
    for j in range(len(bias)):
        y[j] = bias[j]
    for i in range(0, whole, 4):  # four at a time: y is read and written a quarter as often, its sums keep their order
        a, b, c, d = x[i], x[i + 1], x[i + 2], x[i + 3]
        for j in range(len(bias)):
            y[j] = y[j] + a * weight[i, j] + b * weight[i + 1, j] + c * weight[i + 2, j] + d * weight[i + 3, j]
    for i in range(whole, inputs):
        value = x[i]
        for j in range(len(bias)):
            y[j] += value * weight[i, j]


@inner
def activate(y, units, kind):
    """The activation in place."""
    if kind == TANH:
        for j in range(units):
            y[j] = tanh(y[j])
    elif kind == RELU:
        for j in range(units):
            y[j] = max(y[j], 0.0)


@kernel
def feed_forward(weights, biases, activations, inputs, outputs):
    """A stack of dense layers over rows.

    Parameters
    ----------
    weights : tuple of (inputs, outputs) float64 arrays
        The weights of each layer, C order.
    biases : tuple of (outputs,) arrays
    activations : (layers,) int array
        Values of `ACTIVATIONS`.
    inputs : (n, d) array
    outputs : (n, m) array
        Overwritten.
    """
    width = 0
    for layer in range(len(weights)):
        width = max(width, weights[layer].shape[1])
    one, two = np.empty(width), np.empty(width)
    for row in range(len(inputs)):
        x, y = inputs[row], one
        for layer in range(len(weights)):
            dense(weights[layer], biases[layer], x, y)
            activate(y, len(biases[layer]), activations[layer])
            x, y = y, two if layer % 2 == 0 else one
        for j in range(outputs.shape[1]):
            outputs[row, j] = x[j]


@kernel
def long_short_term(w_input, w_hidden, bias, inputs, memory, outputs):
    """One step of an LSTM over rows, gates in the order input, forget, cell, output.

    Parameters
    ----------
    w_input : (d, 4 h) array
    w_hidden : (h, 4 h) array
    bias : (4 h,) array
    inputs : (n, d) array
    memory : (n, 2 h) array
        Hidden state and cell of each row, in place.
    outputs : (n, h) array
        Overwritten with the new hidden state.
    """
    h = w_hidden.shape[0]
    gates, recurrent, zero = np.empty(4 * h), np.empty(4 * h), np.zeros(4 * h)
    for row in range(len(inputs)):
        dense(w_input, bias, inputs[row], gates)
        dense(w_hidden, zero, memory[row, :h], recurrent)
        for j in range(h):
            i, f = sigmoid(gates[j] + recurrent[j]), sigmoid(gates[h + j] + recurrent[h + j])
            g, o = tanh(gates[2 * h + j] + recurrent[2 * h + j]), sigmoid(gates[3 * h + j] + recurrent[3 * h + j])
            cell = f * memory[row, h + j] + i * g
            memory[row, h + j] = cell
            outputs[row, j] = o * tanh(cell)
        for j in range(h):
            memory[row, j] = outputs[row, j]
