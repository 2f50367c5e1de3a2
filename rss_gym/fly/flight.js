// Encounters one at a time, on the translated kernels in `$parts`. An action is [along, right] in shares of the speed
// limits; a flight's records have the names and units of rss_gym.state and rss_gym.sensed.

/** The start of encounter `number` of the suite. */
function begin(number) {
  const flight = { done: false, decisions: 0 };
  for (const name of ["state", "seen", "mask", "split", "seeds", "numbers", "actions", "observations", "rewards"]) {
    flight[name] = $parts[name]();
  }
  flight.split[0] = $parts.flown.split;
  flight.seeds[0] = $parts.flown.seed;
  flight.numbers[0] = BigInt(number);
  const failed = $parts.reset(
    flight.state, flight.seen, flight.mask, flight.split, flight.seeds, flight.numbers, flight.observations,
  );
  if (failed >= 0) throw new Error(`encounter ${number} could not be drawn`);
  flight.episode = flight.state.episode[0];
  return flight;
}

/** One decision of a flight with an action, which is held as a policy's is: a float32 in [-1, 1]. */
function advance(flight, action) {
  for (let axis = 0; axis < 3; axis++) {
    flight.actions[axis] = Math.fround(Math.min(1, Math.max(-1, action[axis] || 0)));
  }
  const failed = $parts.step(
    flight.state, flight.seen, flight.mask, flight.actions, flight.observations, flight.rewards,
  );
  if (failed >= 0) throw new Error("the state of the flight is not finite");
  flight.decisions += 1;
  flight.done = flight.episode.terminated || flight.episode.truncated;
}

/** What the agent commands, seeing what the flight shows. */
function think(flight) {
  const outputs = new Float64Array($parts.outputs);
  $parts.think(...$parts.layers, Float64Array.from(flight.observations), outputs);
  return outputs;
}

/** A whole flight of an encounter: `act` gives the actions, `watch` is called at the start and after each decision. */
function fly(number, act = think, watch = () => {}) {
  const flight = begin(number);
  watch(flight);
  while (!flight.done) {
    advance(flight, act(flight));
    watch(flight);
  }
  return flight;
}

return { begin, advance, think, fly };
