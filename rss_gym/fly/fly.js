// The flight of a person: keys and pad, the clock, what is shown meanwhile, and the comparison at the end.
(() => {
  const facts = JSON.parse(document.getElementById("data").textContent);
  const live = document.getElementById("live"), end = document.getElementById("end"), tally = document.getElementById("tally");
  const part = (name) => document.querySelector(`[data-part="${name}"]`);
  const SPEEDS = [1, 2, 4, 8], SETTLE_S = 0.15; // time in which a jump of an estimate is drawn
  const NO_JUMPS = { own: [0, 0], fix: [0, 0], others: [] };
  const game = { index: 0, speed: 1, running: false, over: kept(), keys: new Set(), pad: null };
  const replay = { t: 0, playing: false };

  // -- the tally of former visits; a browser may refuse to keep it, and then it lasts as long as the page ------------

  function kept() {
    const numbers = ({ cost, closest }) => Number.isFinite(cost) && Number.isFinite(closest);
    const whole = ({ index, mine, its }) => index in facts.encounters && numbers(mine) && numbers(its);
    try {
      const over = JSON.parse(localStorage.getItem(facts.key)) || [];
      return over.every(whole) ? over : [];
    } catch {
      return [];
    }
  }

  function keep() {
    try {
      if (game.over.length) localStorage.setItem(facts.key, JSON.stringify(game.over));
      else localStorage.removeItem(facts.key);
    } catch { /* this page has the tally all the same */ }
  }

  // -- what is known, and what was true -----------------------------------------------------------------------------

  const pair = (vector) => [vector[0], vector[1]];
  const added = (a, b, scale = 1) => [a[0] + scale * b[0], a[1] + scale * b[1]];
  const apart = (a, b) => Math.hypot(a[0] - b[0], a[1] - b[1]);

  /** What was true after a decision, for the end. */
  function truth(flight) {
    const { aircraft, contacts } = flight.state, position = pair(aircraft[0].position_m);
    const others = contacts.slice(0, flight.episode.intruders).map((contact, k) => ({
      position: pair(aircraft[1 + k].position_m), motion: pair(aircraft[1 + k].velocity_mps), warning: contact.warning,
    }));
    return {
      position, others, motion: pair(aircraft[0].velocity_mps), planned: pair(aircraft[0].planned_m),
      separation: Math.min(...others.map((other) => apart(other.position, position))),
    };
  }

  /** What a policy is told after a decision, in world axes; nothing of it is read from the true state. */
  function sensed(flight) {
    const own = flight.seen.own[0], position = pair(own.position_m), velocity = pair(own.velocity_mps);
    const others = flight.seen.others.filter((other) => other.present).map((other, k) => {
      const track = flight.state.tracks[k];
      return {
        range: other.range_m, std: other.range_std_m, rate: other.range_rate_mps, radius: other.radius_m,
        warning: other.warning, message: other.valid ? pair(other.position_m) : null,
        relative: track.valid ? pair(track.position_m) : null, closing: pair(track.velocity_mps),
        xx: track.xx, xy: track.xy, yy: track.yy,
      };
    });
    return {
      position, velocity, others, planned: pair(own.planned_m), plannedVelocity: pair(own.planned_mps),
      along: pair(own.along), wayPoint: pair(own.way_point_m), fixStd: own.std_m, ahead: added(own.planned_m, own.ahead_m),
    };
  }

  const scores = ({ episode }) => ({
    cost: episode.cost_m, closest: episode.min_separation_m, deviation: episode.deviation_mean_m,
    snmac: episode.snmac, collision: episode.collision,
  });

  // -- flying -------------------------------------------------------------------------------------------------------

  const encounter = () => facts.encounters[game.index];

  function load(index) {
    game.index = (index + facts.encounters.length) % facts.encounters.length;
    const flight = game.flight = rssWorld.begin(encounter().number);
    Object.assign(game, {
      running: false, started: false, since: 0, pressed: [0, 0], samples: [truth(flight)], known: sensed(flight), trail: [],
      plannedTrail: [], tracks: flight.seen.others.map(() => []), jumps: NO_JUMPS, view: null, grid: pair(flight.seen.own[0].along),
    });
    replay.playing = false;
    live.hidden = false;
    end.hidden = true;
    part("which").textContent = `Encounter ${game.index + 1} of ${facts.encounters.length}`;
    buttons();
    draw(0);
  }

  /** Deflection of the commanded velocity, [along, right] in shares of the speed limit. */
  function deflection() {
    if (game.pad) return game.pad;
    const held = (one, other) => (game.keys.has(one) ? 1 : 0) - (game.keys.has(other) ? 1 : 0);
    return [held("ArrowUp", "ArrowDown"), held("ArrowRight", "ArrowLeft")];
  }

  /** One decision with the mean deflection since the last one. */
  function decide(action) {
    const before = drawn(game.known, game.since), { flight } = game;
    rssWorld.advance(flight, action);
    game.trail.push(game.known.wayPoint);
    game.plannedTrail.push(game.known.planned);
    game.known.others.forEach((other, k) => {
      if (other.relative) game.tracks[k].push(added(game.known.wayPoint, other.relative));
    });
    game.samples.push(truth(flight));
    game.known = sensed(flight);
    const after = drawn(game.known, 0, false);
    game.jumps = {
      own: added(before.own, after.own, -1), fix: added(before.fix, after.fix, -1),
      others: after.others.map((other, k) =>
        (other.track && before.others[k].track ? added(before.others[k].track, other.track, -1) : [0, 0])),
    };
  }

  /** Planned velocity plus what the keys add, m/s, below the limit. */
  function commanded({ plannedVelocity, along }) {
    const [forth, right] = deflection(), most = facts.speed_mps;
    const sum = added(added(plannedVelocity, along, most * forth), [along[1], -along[0]], most * right);
    const size = Math.hypot(...sum);
    return size > most ? sum.map((value) => value * most / size) : sum;
  }

  /**
   * What is drawn `since` seconds after a decision: everything goes on as it is known to move. The aircraft stands at
   * its way point, which it knows exactly and its autopilot follows; its radio fix is drawn beside.
   */
  function drawn(known, since, jumping = true) {
    const settle = jumping ? Math.exp(-since / SETTLE_S) : 0, command = commanded(known);
    const own = added(added(known.wayPoint, command, since), game.jumps.own, settle);
    const fix = added(added(known.position, known.velocity, since), game.jumps.fix, settle);
    const others = known.others.map((other, k) => {
      const velocity = added(known.velocity, other.closing);
      const track = other.relative && added(
        added(added(known.wayPoint, other.relative), velocity, since), game.jumps.others[k] || [0, 0], settle,
      );
      return { ...other, track, velocity, trail: game.tracks[k], range: Math.max(other.range + other.rate * since, 0) };
    });
    return {
      own, fix, others, fixStd: known.fixStd, velocity: command, planned: added(known.planned, known.plannedVelocity, since),
      ahead: added(known.ahead, known.plannedVelocity, since), trail: game.trail, plannedTrail: game.plannedTrail,
    };
  }

  function frame(stamp) {
    if (!game.running) return;
    const passed = game.before === null ? 0 : Math.min(stamp - game.before, 100) / 1000 * game.speed;
    game.before = stamp;
    let left = passed;
    while (left > 0 && !game.flight.done) {
      const step = Math.min(left, facts.decision_s - game.since);
      game.pressed = added(game.pressed, deflection(), step);
      game.since += step;
      left -= step;
      if (game.since >= facts.decision_s - 1e-9) {
        decide(game.pressed.map((sum) => sum / facts.decision_s));
        game.since = 0;
        game.pressed = [0, 0];
      }
    }
    draw(passed / game.speed);
    if (game.flight.done) return finish();
    requestAnimationFrame(frame);
  }

  function toggle() {
    if (!end.hidden) return;
    game.running = !game.running;
    game.started = true;
    game.before = null;
    buttons();
    if (!game.running) return;
    if (window.matchMedia("(max-width: 719px)").matches) live.scrollIntoView(); // map and pad together
    requestAnimationFrame(frame);
  }

  function buttons() {
    part("play").textContent = game.running ? "Pause" : game.started ? "Go on" : "Start";
    part("overlay").hidden = game.running || game.started;
    document.querySelectorAll(".speeds button").forEach((button) =>
      button.setAttribute("aria-pressed", String(Number(button.value) === game.speed)));
  }

  // -- the live picture ---------------------------------------------------------------------------------------------

  /** The view follows the aircraft, up along the path, as wide as the range needs; `wall` seconds went by. */
  function viewed(shown, wall) {
    const { along } = game.known, angle = Math.atan2(along[1], along[0]);
    const far = Math.max(...shown.others.map((other) => other.range), 1.2 * apart(shown.own, shown.planned));
    const half = Math.min(Math.max(1.1 * far + 8, 40), 220);
    const old = game.view, share = old ? 1 - Math.exp(-wall / 0.5) : 1;
    const turn = old ? Math.atan2(Math.sin(angle - old.angle), Math.cos(angle - old.angle)) : 0;
    const now = { angle: old ? old.angle + turn * share : angle, half: old ? old.half + (half - old.half) * share : half };
    game.view = now;
    return { ...now, up: [Math.cos(now.angle), Math.sin(now.angle)], centre: shown.own, grid: game.grid };
  }

  function draw(wall) {
    if (live.hidden) return drawEnd();
    const shown = drawn(game.known, game.since);
    rssDraw.radio(part("map"), shown, viewed(shown, wall));
    const open = game.known.others.some((other) => other.warning);
    part("alarm").hidden = !open;
    read(shown, open);
    const [forth, right] = deflection(), size = Math.max(Math.hypot(forth, right), 1);
    part("pad").querySelector(".knob").style.transform = `translate(${right / size * 3.1}rem, ${-forth / size * 3.1}rem)`;
    for (const [name, on] of [["up", forth > 0.3], ["down", forth < -0.3], ["right", right > 0.3], ["left", right < -0.3]]) {
      part("pad").querySelector(`.${name}`).classList.toggle("on", on);
    }
  }

  /** Closest approach if both fly on as they do, by the track: time and distance. */
  function approach({ relative, closing }) {
    const square = closing[0] ** 2 + closing[1] ** 2;
    const time = square > 1e-6 ? Math.max(0, -(relative[0] * closing[0] + relative[1] * closing[1]) / square) : 0;
    return { time, miss: Math.hypot(...added(relative, closing, time)) };
  }

  function read(shown, open) {
    const nearest = shown.others.reduce((a, b) => (b.range < a.range ? b : a));
    const flown = (game.flight.decisions * facts.decision_s + game.since).toFixed(1);
    const side = added(shown.own, shown.planned, -1);
    const rows = [
      ["Time", `${flown} s`],
      ["Range of the other, by radio", `${nearest.range.toFixed(0)} ± ${nearest.std.toFixed(0)} m`, open],
      ["Distance from your path", `${Math.hypot(...side).toFixed(1)} m`],
    ];
    if (nearest.relative) {
      const { time, miss } = approach(nearest);
      rows.push(["If both fly on", time > 0 ? `${miss.toFixed(0)} m apart in ${time.toFixed(0)} s` : "you move apart"]);
    } else rows.push(["If both fly on", "no message yet"]);
    part("readings").replaceChildren(...rows.flatMap(([name, text, bad]) => {
      const term = document.createElement("dt"), value = document.createElement("dd");
      term.textContent = name;
      value.textContent = text;
      value.classList.toggle("bad", Boolean(bad));
      return [term, value];
    }));
  }

  // -- the end ------------------------------------------------------------------------------------------------------

  function finish() {
    game.running = false;
    const samples = [], agent = rssWorld.fly(encounter().number, rssWorld.think, (flight) => samples.push(truth(flight)));
    const mine = { samples: game.samples, ...scores(game.flight) }, its = { samples, ...scores(agent) };
    game.result = { mine, its };
    game.over.push({ index: game.index, family: encounter().family, mine: scores(game.flight), its: scores(agent) });
    keep();
    replay.box = box([mine, its]);
    replay.end = Math.max(...[mine, its].map((flight) => (flight.samples.length - 1) * facts.decision_s));
    replay.t = replay.end;
    part("time").max = replay.end;
    live.hidden = true;
    end.hidden = false;
    part("verdict").textContent = verdict(mine, its);
    table(part("scores"), ["", "You", facts.agent], compared(mine, its));
    showTally();
    drawEnd();
    if (end.getBoundingClientRect().top < 0) end.scrollIntoView();
    part("next").focus({ preventScroll: true });
  }

  const metres = (value) => (value < 100 ? value.toFixed(2) : Math.round(value).toLocaleString("en"));

  function verdict(mine, its) {
    const number = `Encounter ${game.index + 1}, ${encounter().family}: `;
    if (mine.collision) return `${number}you collided${its.collision ? ", and so did the agent" : ""}.`;
    if (its.collision) return `${number}you win, the agent collided.`;
    const difference = Math.abs(mine.cost - its.cost);
    if (difference < 0.005) return `${number}a draw.`;
    return `${number}${mine.cost < its.cost ? "you win" : `${facts.agent} wins`} by ${metres(difference)} m.`;
  }

  function compared(mine, its) {
    const flag = (name) => [[mine, its].map((flight) => (flight[name] ? "yes" : "no")), [mine, its].map((f) => (f[name] ? "bad" : ""))];
    const better = (name, low) => [mine, its].map((flight, k, [a, b]) =>
      (low && (k ? b[name] < a[name] : a[name] < b[name]) ? "win" : ""));
    const row = (title, name, low) => [title, [mine, its].map((flight) => `${metres(flight[name])} m`), better(name, low)];
    return [
      row("Cost", "cost", true), row("Mean distance from the path", "deviation"), row("Closest approach", "closest"),
      [`Near miss, below ${facts.snmac_m} m`, ...flag("snmac")], ["Collision", ...flag("collision")],
    ].map(([title, values, classes]) => ({ cells: [title, ...values], classes: ["", ...classes] }));
  }

  function table(element, header, rows) {
    const made = (kind, text, name = "") => {
      const cell = document.createElement(kind);
      cell.textContent = text;
      if (name) cell.className = name;
      return cell;
    };
    const head = document.createElement("thead"), body = document.createElement("tbody"), line = document.createElement("tr");
    line.append(...header.map((text) => made("th", text)));
    head.append(line);
    for (const { cells, classes } of rows) {
      const row = document.createElement("tr");
      row.append(...cells.map((text, k) => made(k ? "td" : "th", text, classes[k])));
      body.append(row);
    }
    element.replaceChildren(head, body);
  }

  function showTally() {
    const { over } = game;
    tally.hidden = !over.length;
    if (!over.length) return;
    const mean = (who) => over.reduce((sum, flown) => sum + flown[who].cost, 0) / over.length;
    const wins = over.filter((flown) => flown.mine.cost < flown.its.cost).length;
    const hits = (who) => over.filter((flown) => flown[who].collision).length;
    const flown = over.length === 1 ? "One encounter" : `${over.length} encounters`;
    part("sum").textContent = `${flown}: your mean cost is ${metres(mean("mine"))} m and ${facts.agent}'s `
      + `${metres(mean("its"))} m. You were cheaper in ${wins}. Collisions: you ${hits("mine")}, the agent ${hits("its")}.`;
    const rows = [...over].reverse().map(({ index, family, mine, its }) => ({
      cells: [`${index + 1}, ${family}`, ...[mine.cost, its.cost, mine.closest, its.closest].map((value) => `${metres(value)} m`)],
      classes: ["", mine.collision ? "bad" : mine.cost < its.cost ? "win" : "", its.collision ? "bad" : its.cost < mine.cost ? "win" : ""],
    }));
    table(part("rows"), ["Encounter", "Your cost", "Its cost", "Your closest", "Its closest"], rows);
  }

  /** Middle and half sides in metres of a box that holds the flights, turned as the maps are. */
  function box(flights) {
    const [ux, uy] = replay.up = heading(), sides = [[Infinity, -Infinity], [Infinity, -Infinity]];
    for (const { samples } of flights) {
      for (const sample of samples) {
        for (const [x, y] of [sample.position, sample.planned, ...sample.others.map((other) => other.position)]) {
          [x * uy - y * ux, x * ux + y * uy].forEach((value, axis) => {
            sides[axis] = [Math.min(sides[axis][0], value), Math.max(sides[axis][1], value)];
          });
        }
      }
    }
    const [right, forth] = sides.map(([low, high]) => (low + high) / 2);
    return {
      centre: [right * uy + forth * ux, forth * uy - right * ux], half: sides.map(([low, high]) => (high - low) / 2 + 12),
    };
  }

  function heading() {
    const [first, second] = game.samples, way = added(second.planned, first.planned, -1), size = Math.hypot(...way);
    return size > 0 ? way.map((value) => value / size) : [0, 1];
  }

  function drawEnd() {
    const { mine, its } = game.result;
    const longer = its.samples.length > mine.samples.length ? its : mine;
    rssDraw.map(part("mine"), mine, longer, replay.t, replay.box, replay.up, facts);
    rssDraw.map(part("its"), its, longer, replay.t, replay.box, replay.up, facts);
    replay.axis = rssDraw.graph(part("graph"), [mine, its], replay.t, replay.end, facts);
    part("time").value = replay.t;
    part("clock").textContent = `${replay.t.toFixed(1)} of ${replay.end.toFixed(0)} s`;
    part("replay").textContent = replay.playing ? "❚❚" : "▶";
    part("replay").setAttribute("aria-label", replay.playing ? "Pause" : "Play");
  }

  function seek(t) {
    replay.t = Math.min(Math.max(t, 0), replay.end);
    replay.playing = false;
    drawEnd();
  }

  function play() {
    replay.playing = !replay.playing;
    if (replay.t >= replay.end) replay.t = 0;
    let before = null;
    const step = (stamp) => {
      if (!replay.playing || end.hidden) return;
      if (before !== null) replay.t = Math.min(replay.t + Math.min(stamp - before, 100) / 1000 * 6, replay.end);
      before = stamp;
      if (replay.t >= replay.end) replay.playing = false;
      drawEnd();
      requestAnimationFrame(step);
    };
    drawEnd();
    requestAnimationFrame(step);
  }

  // -- controls -----------------------------------------------------------------------------------------------------

  function setSpeed(speed) {
    game.speed = speed;
    buttons();
  }

  for (const speed of SPEEDS) {
    const button = document.createElement("button");
    Object.assign(button, { type: "button", value: speed, textContent: `${speed}×` });
    button.addEventListener("click", () => setSpeed(speed));
    document.querySelector(".speeds").append(button);
  }
  const click = (name, action) => part(name).addEventListener("click", action);
  click("play", toggle);
  click("overlay", toggle);
  click("again", () => load(game.index));
  click("skip", () => load(game.index + 1));
  click("next", () => { load(game.index + 1); toggle(); });
  click("repeat", () => { load(game.index); toggle(); });
  click("replay", play);
  click("forget", () => { game.over = []; keep(); showTally(); });
  part("time").addEventListener("input", () => seek(Number(part("time").value)));
  const scrub = (event) => {
    const { left, right } = replay.axis;
    seek((event.clientX - part("graph").getBoundingClientRect().left - left) / (right - left) * replay.end);
  };
  part("graph").addEventListener("pointerdown", (event) => { part("graph").setPointerCapture(event.pointerId); scrub(event); });
  part("graph").addEventListener("pointermove", (event) => { if (event.buttons) scrub(event); });

  window.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.altKey || event.metaKey || live.hidden) return;
    if (event.key.startsWith("Arrow") && game.running) game.keys.add(event.key);
    else if (event.key === " " && !(event.target instanceof HTMLButtonElement)) toggle();
    else if (event.key === " " && game.running) toggle();
    else if ((event.key === "r" || event.key === "R") && !event.repeat) load(game.index);
    else if ((event.key === "n" || event.key === "N") && !event.repeat) load(game.index + 1);
    else if (SPEEDS.includes(Number(event.key))) setSpeed(Number(event.key));
    else return;
    event.preventDefault();
  });
  window.addEventListener("keyup", (event) => {
    game.keys.delete(event.key);
    if (event.key === " " && event.target instanceof HTMLButtonElement && !live.hidden && game.started) event.preventDefault();
  });
  window.addEventListener("blur", () => game.keys.clear());
  document.addEventListener("visibilitychange", () => { if (document.hidden && game.running) toggle(); });

  const pad = part("pad");
  const lean = (event) => {
    const place = pad.getBoundingClientRect(), radius = place.width / 2;
    let [x, y] = [(event.clientX - place.left) / radius - 1, 1 - (event.clientY - place.top) / radius];
    const size = Math.hypot(x, y);
    if (size > 0.75) [x, y] = [x / size, y / size]; // the arrows are full deflections
    game.pad = size < 0.15 ? [0, 0] : [y, x];
    if (!game.running) draw(0);
  };
  const release = () => { game.pad = null; draw(0); };
  pad.addEventListener("pointerdown", (event) => { pad.setPointerCapture(event.pointerId); lean(event); event.preventDefault(); });
  pad.addEventListener("pointermove", (event) => { if (game.pad) lean(event); });
  for (const name of ["pointerup", "pointercancel"]) pad.addEventListener(name, release);

  window.addEventListener("resize", () => draw(0));
  window.matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => draw(0));

  /** `#encounter=3&keys=up,left&time=20`: that encounter, flown for 20 s (or to its `end`) with these keys held. */
  function follow() {
    const wanted = new URLSearchParams(location.hash.slice(1));
    load((Number(wanted.get("encounter")) || 1) - 1);
    if (!wanted.has("time")) return;
    const keys = (wanted.get("keys") || "").split(",").map((name) => `Arrow${name.charAt(0).toUpperCase()}${name.slice(1)}`);
    game.keys = new Set(keys);
    const until = wanted.get("time") === "end" ? Infinity : Number(wanted.get("time"));
    game.started = true;
    while (!game.flight.done && game.flight.decisions * facts.decision_s < until) decide(deflection());
    game.keys.clear();
    game.jumps = NO_JUMPS;
    game.view = null;
    buttons();
    if (game.flight.done) finish(); else draw(0);
  }
  window.addEventListener("hashchange", follow);
  showTally();
  follow();
})();
