// The player of recorded flights. Positions are decimetres on (east, north[, up]), separations centimetres.
(() => {
  const source = document.getElementById("data-replays");
  const player = document.getElementById("player");
  if (!source || !player) return;
  const data = JSON.parse(source.textContent);
  if (!data.policies.length) return;
  player.hidden = false;

  const AXES = data.planar ? 2 : 3;
  const CLOSE_M = 45; // half the width of the close-up
  const part = (name) => player.querySelector(`[data-part="${name}"]`);
  const [policy, choice, view, play, time, clock, speed, graph] =
    ["policy", "case", "view", "play", "time", "clock", "speed", "graph"].map(part);
  const panels = [...player.querySelectorAll("figure")].map((figure) => ({
    figure, title: figure.querySelector("figcaption"), canvas: figure.querySelector("canvas"), state: figure.querySelector("p"),
  }));
  const now = { t: 0, end: 1, playing: false, fresh: true, flights: [], frame: null };

  // -- flights ------------------------------------------------------------------------------------------------------

  /** Index of the last sample at or before t, and how far t is on the way to the next one. */
  function moment(flight, t) {
    const times = flight.times;
    let k = Math.min(Math.floor(t / data.decision_s + 1e-6), times.length - 1);
    if (t >= times[times.length - 1]) k = times.length - 1;
    const next = Math.min(k + 1, times.length - 1);
    return { k, next, share: next > k ? (t - times[k]) / (times[next] - times[k]) : 0 };
  }

  /** Vector in metres of sample k, or null. */
  function sample(column, k) {
    if (column[AXES * k] === null) return null;
    return [column[AXES * k] / 10, column[AXES * k + 1] / 10, AXES > 2 ? column[AXES * k + 2] / 10 : 0];
  }

  function at(column, when) {
    const a = sample(column, when.k), b = sample(column, when.next);
    return a && b ? a.map((value, axis) => value + when.share * (b[axis] - value)) : a;
  }

  const distance = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1], a[2] - b[2]);

  function separation(flight, when) {
    const own = at(flight.own.position, when);
    return Math.min(...flight.intruders.map((other) => distance(own, at(other.position, when))));
  }

  // -- drawing ------------------------------------------------------------------------------------------------------

  const { colours, prepared, stroke, circle, dart } = rssCanvas;

  /** Middle and half sides in metres of a box that holds both flights, the same for both maps. */
  function box() {
    let [west, south, east, north] = [Infinity, Infinity, -Infinity, -Infinity];
    for (const flight of now.flights) {
      for (const column of [flight.own.position, flight.own.planned, ...flight.intruders.map((other) => other.position)]) {
        for (let k = 0; k < column.length; k += AXES) {
          west = Math.min(west, column[k] / 10); east = Math.max(east, column[k] / 10);
          south = Math.min(south, column[k + 1] / 10); north = Math.max(north, column[k + 1] / 10);
        }
      }
    }
    return { centre: [(west + east) / 2, (south + north) / 2], half: [(east - west) / 2 + 12, (north - south) / 2 + 12] };
  }

  function niceStep(length) {
    const power = 10 ** Math.floor(Math.log10(length));
    return power * [1, 2, 5, 10].find((step) => step * power >= length * (1 - 1e-9));
  }

  function drawMap(panel, flight, ink) {
    const { pen, width, height } = prepared(panel.canvas, ink.panel);
    const when = moment(flight, now.t);
    const own = at(flight.own.position, when);
    const close = view.value === "close";
    // The close-up follows the middle between agent and nearest intruder of the first flight, for both maps alike.
    const whole = now.box;
    const centre = close ? now.middle : whole.centre;
    const scale = close ? Math.min(width, height) / (2 * CLOSE_M)
      : Math.min(width / (2 * whole.half[0]), height / (2 * whole.half[1]));
    const px = (point) => [width / 2 + (point[0] - centre[0]) * scale, height / 2 - (point[1] - centre[1]) * scale];
    const path = (column, first, last) => {
      const points = [];
      for (let k = first; k <= last; k++) points.push(px(sample(column, k)));
      return points;
    };
    const last = flight.times.length - 1;
    // What lay ahead of a flight that ended early is known from the longer one.
    const longer = now.flights.reduce((a, b) => (b.times.length > a.times.length ? b : a));
    const entire = flight.collision ? longer : flight;
    const end = entire.times.length - 1;

    const cell = niceStep(Math.max(width, height) / scale / 7);
    for (const axis of [0, 1]) {
      const half = (axis ? height : width) / scale / 2;
      for (let k = Math.ceil((centre[axis] - half) / cell); k * cell <= centre[axis] + half; k++) {
        const spot = px([k * cell, k * cell])[axis];
        stroke(pen, axis ? [[0, spot], [width, spot]] : [[spot, 0], [spot, height]], ink.line, 1);
      }
    }
    const spot = px(own), nearest = nearestRange(flight, when.k);
    for (const other of flight.intruders) {
      pen.globalAlpha = other === nearest ? 1 : 0.3; // rings of several intruders would hide each other
      const there = px(at(other.position, when)), open = other.warning[when.k] === 1;
      const colour = open ? ink.red : ink.orange, zone = other.zone[when.k] / 10 * scale;
      circle(pen, there, zone, { line: colour, width: open ? 1.6 : 1.2, dash: open ? [] : [5, 4] });
      if (other.range[when.k] !== null) {
        const range = other.range[when.k] / 10 * scale, std = (other.std[when.k] || 0) / 10 * scale;
        circle(pen, spot, range, { line: ink.ring, width: 1.5 });
        if (other === nearest) circle(pen, spot, range + std, { fill: ink.ring, alpha: 0.16, inner: Math.max(0, range - std) });
      }
    }
    pen.globalAlpha = 1;
    stroke(pen, path(entire.own.planned, 0, end), ink.blue, 1.2, [4, 4], 0.7);
    flight.intruders.forEach((other, index) => {
      const colour = other.warning[when.k] === 1 ? ink.red : ink.orange;
      stroke(pen, path(entire.intruders[index].position, when.k, end), colour, 1.1, [4, 4], 0.6);
      stroke(pen, [...path(other.position, 0, when.k), px(at(other.position, when))], colour, 2);
    });
    stroke(pen, [...path(flight.own.position, 0, when.k), spot], ink.blue, 2);
    for (const other of flight.intruders) {
      const colour = other.warning[when.k] === 1 ? ink.red : ink.orange;
      const there = px(at(other.position, when)), message = sample(other.message, when.k);
      if (message) {
        const [x, y] = px(message);
        stroke(pen, [there, [x, y]], colour, 1, [], 0.6);
        stroke(pen, [[x - 4, y - 4], [x + 4, y + 4]], colour, 1.6);
        stroke(pen, [[x + 4, y - 4], [x - 4, y + 4]], colour, 1.6);
      }
      dart(pen, there, heading(other.position, when, px), colour, ink.paper);
      circle(pen, there, data.collision_m * scale, { line: ink.ink, width: 1 });
    }
    const planned = px(at(flight.own.planned, when)), point = px(at(flight.own.way_point, when));
    if (Math.hypot(point[0] - spot[0], point[1] - spot[1]) > 7) {
      const [x, y] = point;
      stroke(pen, [spot, point], ink.blue, 1, [], 0.6);
      stroke(pen, [[x - 5, y], [x, y - 5], [x + 5, y], [x, y + 5], [x - 5, y]], ink.blue, 1.6);
    }
    if (Math.hypot(planned[0] - spot[0], planned[1] - spot[1]) > 7) circle(pen, planned, 4, { line: ink.blue, width: 1.6 });
    dart(pen, spot, heading(flight.own.position, when, px), ink.blue, ink.paper);
    if (flight.collision && when.k === last) {
      for (let k = 0; k < 8; k++) {
        const [c, s] = [Math.cos(k * Math.PI / 4), Math.sin(k * Math.PI / 4)];
        stroke(pen, [[spot[0] + 9 * c, spot[1] + 9 * s], [spot[0] + 17 * c, spot[1] + 17 * s]], ink.red, 2);
      }
    }
    const length = cell * scale, [left, base] = [12, height - 12];
    stroke(pen, [[left, base - 4], [left, base], [left + length, base], [left + length, base - 4]], ink.ink, 1.4);
    pen.textAlign = "center";
    pen.lineWidth = 3;
    pen.strokeStyle = ink.panel;
    pen.strokeText(`${cell} m`, left + length / 2, base - 6);
    pen.fillStyle = ink.ink;
    pen.fillText(`${cell} m`, left + length / 2, base - 6);
    describe(panel, flight, when);
  }

  /** The intruder with the smallest estimated range. */
  function nearestRange(flight, k) {
    const known = (other) => (other.range[k] === null ? Infinity : other.range[k]);
    return flight.intruders.reduce((a, b) => (known(b) < known(a) ? b : a));
  }

  function heading(column, when, px) {
    const a = sample(column, when.next > when.k ? when.k : Math.max(when.k - 1, 0)), b = sample(column, when.next);
    if (Math.hypot(b[0] - a[0], b[1] - a[1]) < 0.35 * data.decision_s) return [0, 0]; // hovers, but for gusts
    const [start, end] = [px(a), px(b)];
    return [end[0] - start[0], end[1] - start[1]];
  }

  function describe(panel, flight, when) {
    const open = flight.intruders.some((other) => other.warning[when.k] === 1);
    const nearest = nearestRange(flight, when.k);
    const words = [];
    const apart = separation(flight, when), least = Math.min(apart, flight.least[when.k] / 100);
    words.push(`separation ${apart.toFixed(1)} m, least ${least.toFixed(1)} m`);
    if (nearest.range[when.k] !== null) {
      words.push(`estimate ${(nearest.range[when.k] / 10).toFixed(0)} ± ${((nearest.std[when.k] || 0) / 10).toFixed(0)} m`);
    }
    if (!data.planar) {
      const up = at(nearest.position, when)[2] - at(flight.own.position, when)[2];
      words.push(`intruder ${Math.abs(up).toFixed(1)} m ${up < 0 ? "below" : "above"}`);
    }
    if (!flight.same) words.push("not as scored");
    const spans = words.map((text) => span(text));
    if (flight.collision && when.k === flight.times.length - 1) spans.unshift(span(`collision at ${flight.times[when.k].toFixed(1)} s`, "warning"));
    else spans.unshift(open ? span("warning", "warning") : span("no warning"));
    panel.state.replaceChildren(...spans);
    panel.canvas.setAttribute("aria-label", `${flight.name}: ${words.join(", ")}`);
  }

  function span(text, name = "") {
    const out = document.createElement("span");
    out.textContent = text;
    out.className = name;
    return out;
  }

  function drawGraph(ink) {
    const { pen, width, height } = prepared(graph, ink.panel);
    const [left, right, top, bottom] = [48, width - 68, 10, height - 22];
    const [low, high] = [0.3, Math.max(2 * data.zone_m, 10)];
    const x = (t) => left + (t / now.end) * (right - left);
    const y = (metres) => bottom - Math.log(Math.max(metres, low) / low) / Math.log(high / low) * (bottom - top);
    now.axis = { left, right };
    pen.textAlign = "right";
    pen.fillStyle = ink.muted;
    for (const metres of [1, 10, 100]) {
      stroke(pen, [[left, y(metres)], [right, y(metres)]], ink.line, 1);
      pen.fillText(`${metres} m`, left - 6, y(metres) + 4);
    }
    const step = niceStep(now.end / (width > 500 ? 10 : 5));
    pen.textAlign = "center";
    for (let t = 0; t <= now.end; t += step) pen.fillText(`${t} s`, x(t), height - 6);
    for (const [metres, colour, name] of [[data.zone_m, ink.orange, "zone"], [data.collision_m, ink.red, "collision"]]) {
      stroke(pen, [[left, y(metres)], [right, y(metres)]], colour, 1, [5, 4], 0.9);
      pen.textAlign = "left";
      pen.fillStyle = colour;
      pen.fillText(name, right + 8, y(metres) + 4);
    }
    now.flights.forEach((flight, index) => {
      const points = flight.times.map((t, k) => [x(t), y(separation(flight, { k, next: k, share: 0 }))]);
      stroke(pen, points, index ? ink.muted : ink.blue, index ? 1.4 : 2);
    });
    stroke(pen, [[x(now.t), top], [x(now.t), bottom]], ink.ink, 1);
  }

  function draw() {
    const ink = colours();
    const lead = now.flights[0], when = moment(lead, now.t);
    const own = at(lead.own.position, when);
    const others = lead.intruders.map((other) => at(other.position, when));
    const near = others.reduce((a, b) => (distance(own, b) < distance(own, a) ? b : a));
    now.middle = [(own[0] + near[0]) / 2, (own[1] + near[1]) / 2];
    now.flights.forEach((flight, index) => drawMap(panels[index], flight, ink));
    drawGraph(ink);
    time.value = now.t;
    clock.textContent = `${now.t.toFixed(1)} of ${now.end.toFixed(0)} s`;
  }

  // -- controls -----------------------------------------------------------------------------------------------------

  function option(text, value) {
    const out = document.createElement("option");
    out.textContent = text;
    out.value = value;
    return out;
  }

  const current = () => data.policies[policy.value].cases[choice.value];

  function listCases() {
    choice.replaceChildren(...data.policies[policy.value].cases.map((item, index) =>
      option(`${item.episode}, ${item.family}: ${item.least_m.toFixed(2)} m`, index)));
  }

  function load() {
    pause();
    const item = current();
    now.flights = [item.flight, item.beside].filter((index) => index !== null).map((index) => data.flights[index]);
    panels.forEach((panel, index) => {
      panel.figure.hidden = index >= now.flights.length;
      panel.title.textContent = index < now.flights.length ? now.flights[index].name : "";
    });
    now.end = Math.max(...now.flights.map((flight) => flight.times[flight.times.length - 1]));
    now.box = box();
    now.t = Math.min(item.closest_s, now.end);
    now.fresh = true;
    time.max = now.end;
    draw();
  }

  function seek(t) {
    now.t = Math.min(Math.max(t, 0), now.end);
    now.fresh = false;
    draw();
  }

  function pause() {
    now.playing = false;
    play.textContent = "▶";
    play.setAttribute("aria-label", "Play");
  }

  function toggle() {
    if (now.playing) return pause();
    if (now.fresh || now.t >= now.end) now.t = 0;
    now.fresh = false;
    now.playing = true;
    play.textContent = "❚❚";
    play.setAttribute("aria-label", "Pause");
    let before = null;
    const step = (stamp) => {
      if (!now.playing) return;
      if (before !== null) now.t = Math.min(now.t + Math.min(stamp - before, 100) / 1000 * Number(speed.value), now.end);
      before = stamp;
      draw();
      if (now.t >= now.end) pause(); else requestAnimationFrame(step);
    };
    requestAnimationFrame(step);
  }

  /** `#replay=2.0&t=31.5`: policy, encounter and time, for links. */
  function follow() {
    const found = /^#replay=(\d+)(?:\.(\d+))?(?:&t=([\d.]+))?(&close)?$/.exec(location.hash);
    if (!found || !data.policies[found[1]]) return false;
    policy.value = found[1];
    listCases();
    if (data.policies[found[1]].cases[found[2] || 0]) choice.value = found[2] || 0;
    if (found[4]) view.value = "close";
    load();
    if (found[3]) seek(Number(found[3]));
    document.getElementById("replays").scrollIntoView();
    return true;
  }

  data.policies.forEach((item, index) => policy.append(option(item.name, index)));
  policy.addEventListener("change", () => { listCases(); load(); });
  choice.addEventListener("change", load);
  view.addEventListener("change", draw);
  play.addEventListener("click", toggle);
  time.addEventListener("input", () => { pause(); seek(Number(time.value)); });
  const scrub = (event) => {
    const { left, right } = now.axis;
    pause();
    seek((event.clientX - graph.getBoundingClientRect().left - left) / (right - left) * now.end);
  };
  graph.addEventListener("pointerdown", (event) => { graph.setPointerCapture(event.pointerId); scrub(event); });
  graph.addEventListener("pointermove", (event) => { if (event.buttons) scrub(event); });
  player.addEventListener("keydown", (event) => {
    if (event.target.matches("select") || event.ctrlKey || event.altKey || event.metaKey) return;
    const steps = { ArrowLeft: now.t - data.decision_s, ArrowRight: now.t + data.decision_s, Home: 0, End: now.end };
    if (event.key === " " && event.target !== play) toggle();
    else if (event.key in steps) { pause(); seek(steps[event.key]); }
    else return;
    event.preventDefault();
  });
  window.addEventListener("resize", draw);
  window.addEventListener("hashchange", follow);
  for (const query of ["(prefers-color-scheme: dark)", "print"]) window.matchMedia(query).addEventListener("change", draw);
  policy.value = Math.max(0, data.policies.findIndex((item) => item.name !== data.beside && item.name !== "none"));
  if (!follow()) { listCases(); load(); }
})();
