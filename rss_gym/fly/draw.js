// Drawing on canvases: the radio picture of the live flight, and maps and separations of flights that are over.
const rssDraw = (() => {
  const { colours, prepared, stroke, circle, dart } = rssCanvas;

  function cross(pen, [x, y], colour) {
    stroke(pen, [[x - 4, y - 4], [x + 4, y + 4]], colour, 1.6);
    stroke(pen, [[x + 4, y - 4], [x - 4, y + 4]], colour, 1.6);
  }

  function star(pen, [x, y], colour) {
    for (let k = 0; k < 8; k++) {
      const [c, s] = [Math.cos(k * Math.PI / 4), Math.sin(k * Math.PI / 4)];
      stroke(pen, [[x + 9 * c, y + 9 * s], [x + 17 * c, y + 17 * s]], colour, 2.4);
    }
  }

  /** The 1-sigma ellipse of a covariance in m^2 about a point, as points of the world. */
  function ellipse([x, y], xx, xy, yy) {
    const middle = (xx + yy) / 2, half = Math.hypot((xx - yy) / 2, xy), turn = Math.atan2(2 * xy, xx - yy) / 2;
    const a = Math.sqrt(Math.max(middle + half, 0)), b = Math.sqrt(Math.max(middle - half, 0));
    const [c, s] = [Math.cos(turn), Math.sin(turn)];
    return Array.from({ length: 49 }, (_, k) => {
      const [p, q] = [a * Math.cos(k * Math.PI / 24), b * Math.sin(k * Math.PI / 24)];
      return [x + p * c - q * s, y + p * s + q * c];
    });
  }

  function niceStep(length) {
    const power = 10 ** Math.floor(Math.log10(length));
    return power * [1, 2, 5, 10].find((step) => step * power >= length * (1 - 1e-9));
  }

  /** World to pixels: the direction `up` points up, and `centre` lies in the middle. */
  function projection({ width, height }, centre, scale, up) {
    const [ux, uy] = up, turn = ([x, y]) => [(x * uy - y * ux) * scale, -(x * ux + y * uy) * scale];
    const px = (point) => {
      const [x, y] = turn([point[0] - centre[0], point[1] - centre[1]]);
      return [width / 2 + x, height / 2 + y];
    };
    return { px, turn };
  }

  /** Lines of the world along and across the direction `way`; returns the metres between them. */
  function grid(pen, { width, height }, centre, scale, way, px, ink) {
    const cell = niceStep(Math.max(width, height) / scale / 7), reach = Math.hypot(width, height) / scale;
    const axes = [way, [way[1], -way[0]]];
    for (const [across, along] of [axes, [...axes].reverse()]) {
      const middle = centre[0] * across[0] + centre[1] * across[1], beside = centre[0] * along[0] + centre[1] * along[1];
      for (let k = Math.ceil((middle - reach) / cell); k * cell <= middle + reach; k++) {
        stroke(pen, [-reach, reach].map((s) =>
          px([0, 1].map((axis) => k * cell * across[axis] + (beside + s) * along[axis]))), ink.line, 1);
      }
    }
    return cell;
  }

  function ruler(pen, height, cell, scale, ink) {
    const length = cell * scale, [left, base] = [12, height - 12];
    stroke(pen, [[left, base - 4], [left, base], [left + length, base], [left + length, base - 4]], ink.ink, 1.4);
    label(pen, `${cell} m`, left + length / 2, base - 6, ink.ink, ink.panel, "center");
  }

  function label(pen, text, x, y, colour, ground, align = "left") {
    pen.textAlign = align;
    pen.lineWidth = 3;
    pen.lineJoin = "round";
    pen.strokeStyle = ground;
    pen.strokeText(text, x, y);
    pen.fillStyle = colour;
    pen.fillText(text, x, y);
  }

  /** What a policy is told now: `shown` as fly.js makes it, in metres of the world. */
  function radio(canvas, shown, view) {
    const ink = colours(), size = prepared(canvas, ink.panel), { pen, height } = size;
    const scale = Math.min(size.width, height) / (2 * view.half);
    const { px, turn } = projection(size, view.centre, scale, view.up);
    const cell = grid(pen, size, view.centre, scale, view.grid, px, ink);
    const spot = px(shown.own), path = (points) => points.map(px);
    for (const other of shown.others) {
      const colour = other.warning ? ink.red : ink.orange;
      circle(pen, spot, other.radius * scale, {
        line: colour, width: other.warning ? 1.8 : 1.2, dash: other.warning ? [] : [5, 4],
      });
      if (other.warning) circle(pen, spot, other.radius * scale, { fill: ink.red, alpha: 0.06 });
      circle(pen, spot, (other.range + other.std) * scale, {
        fill: ink.ring, alpha: 0.18, inner: Math.max(0, other.range - other.std) * scale,
      });
      circle(pen, spot, other.range * scale, { line: ink.ring, width: 1.6 });
    }
    stroke(pen, path([...shown.plannedTrail, shown.planned, shown.ahead]), ink.blue, 1.3, [5, 5], 0.75);
    stroke(pen, path([...shown.trail, shown.own]), ink.blue, 2);
    for (const other of shown.others) {
      const colour = other.warning ? ink.red : ink.orange;
      if (!other.track) continue;
      if (other.trail.length) stroke(pen, path([...other.trail, other.track]), colour, 1.6, [], 0.5);
      const rim = path(ellipse(other.track, other.xx, other.xy, other.yy));
      pen.beginPath();
      rim.forEach(([x, y], k) => (k ? pen.lineTo(x, y) : pen.moveTo(x, y)));
      pen.globalAlpha = 0.16;
      pen.fillStyle = colour;
      pen.fill();
      stroke(pen, rim, colour, 1.2);
      const there = px(other.track), ahead = [other.track[0] + 5 * other.velocity[0], other.track[1] + 5 * other.velocity[1]];
      stroke(pen, [there, px(ahead)], colour, 1.4, [2, 3]);
      if (other.message) cross(pen, px(other.message), colour);
      dart(pen, there, turn(other.velocity), colour, ink.paper, 1.2);
    }
    const planned = px(shown.planned), fix = px(shown.fix);
    circle(pen, fix, shown.fixStd * scale, { line: ink.blue, width: 1, dash: [2, 3] });
    stroke(pen, [spot, fix], ink.blue, 1, [], 0.4);
    circle(pen, fix, 2.5, { fill: ink.blue });
    circle(pen, planned, 4.5, { line: ink.blue, width: 1.6, fill: ink.panel });
    dart(pen, spot, turn(shown.velocity), ink.blue, ink.paper, 1.3);
    ruler(pen, height, cell, scale, ink);
  }

  /**
   * A flight that is over, up to `t`, on true positions. `box` is shared by both maps,
   * and what lay ahead of a flight that ended early is known from the `longer` one. */
  function map(canvas, flight, longer, t, box, up, facts) {
    const ink = colours(), size = prepared(canvas, ink.panel), { pen, height } = size;
    const scale = Math.min(size.width / (2 * box.half[0]), height / (2 * box.half[1]));
    const { px, turn } = projection(size, box.centre, scale, up);
    const cell = grid(pen, size, box.centre, scale, up, px, ink);
    const last = flight.samples.length - 1, k = Math.min(Math.floor(t / facts.decision_s + 1e-6), last);
    const now = flight.samples[k], path = (pick, first, end) => flight.samples.slice(first, end + 1).map((s) => px(pick(s)));
    const entire = flight.collision ? longer : flight;
    stroke(pen, entire.samples.map((s) => px(s.planned)), ink.blue, 1.2, [4, 4], 0.7);
    now.others.forEach((other, index) => {
      const pick = (s) => s.others[index].position, colour = other.warning ? ink.red : ink.orange;
      stroke(pen, entire.samples.slice(k).map((s) => px(pick(s))), colour, 1.1, [4, 4], 0.6);
      stroke(pen, path(pick, 0, k), colour, 2);
      dart(pen, px(other.position), turn(other.motion), colour, ink.paper);
      circle(pen, px(other.position), facts.collision_m * scale, { line: ink.ink, width: 1 });
    });
    stroke(pen, path((s) => s.position, 0, k), ink.blue, 2);
    const spot = px(now.position), planned = px(now.planned);
    if (Math.hypot(planned[0] - spot[0], planned[1] - spot[1]) > 7) circle(pen, planned, 4, { line: ink.blue, width: 1.6 });
    dart(pen, spot, turn(now.motion), ink.blue, ink.paper);
    if (flight.collision && k === last) star(pen, spot, ink.red);
    ruler(pen, height, cell, scale, ink);
    label(pen, `${now.separation.toFixed(1)} m apart`, size.width - 10, height - 12, ink.ink, ink.panel, "right");
  }

  /** True separation of flights over time, on a logarithmic axis; returns where the axis of time lies. */
  function graph(canvas, flights, t, end, facts) {
    const ink = colours(), { pen, width, height } = prepared(canvas, ink.panel);
    const [left, right, top, bottom] = [48, width - 76, 12, height - 22], [low, high] = [0.5, 2.5 * facts.zone_m];
    const x = (time) => left + (time / end) * (right - left);
    const y = (metres) => bottom - Math.log(Math.min(Math.max(metres, low), high) / low) / Math.log(high / low) * (bottom - top);
    for (const metres of [1, 10, 100]) {
      stroke(pen, [[left, y(metres)], [right, y(metres)]], ink.line, 1);
      label(pen, `${metres} m`, left - 6, y(metres) + 4, ink.muted, ink.panel, "right");
    }
    const step = niceStep(end / (width > 500 ? 10 : 5));
    for (let time = 0; time <= end; time += step) label(pen, `${time} s`, x(time), height - 6, ink.muted, ink.panel, "center");
    for (const [metres, colour, name] of [
      [facts.zone_m, ink.orange, "zone"], [facts.snmac_m, ink.muted, "near miss"], [facts.collision_m, ink.red, "collision"],
    ]) {
      stroke(pen, [[left, y(metres)], [right, y(metres)]], colour, 1, [5, 4], 0.9);
      label(pen, name, right + 8, y(metres) + 4, colour, ink.panel);
    }
    [...flights].reverse().forEach((flight, index) => {
      const points = flight.samples.map((s, k) => [x(k * facts.decision_s), y(s.separation)]);
      stroke(pen, points, index ? ink.blue : ink.muted, index ? 2.2 : 1.6);
    });
    stroke(pen, [[x(t), top], [x(t), bottom]], ink.ink, 1);
    return { left, right };
  }

  return { radio, map, graph };
})();
