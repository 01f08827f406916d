// Draws one scene at one instant; drawing.js has what it draws with.

/** The position at an instant between samples, or null outside them. */
function positionAt(times, positions, instant) {
  const next = times.findIndex((time) => time >= instant);
  if (next < 0 || instant < times[0]) return null;
  if (next === 0) return positions[0];
  const share = (instant - times[next - 1]) / (times[next] - times[next - 1]);
  return add(scaled(positions[next - 1], 1 - share), scaled(positions[next], share));
}

/** Numbers in threes as points. */
const inThrees = (numbers) =>
  Array.from({ length: numbers.length / 3 }, (_, k) => numbers.slice(3 * k, 3 * k + 3));

/** Every point that the picture is to hold, their middle and their size. */
function sceneExtent({ measured, ball, forecasts, arm }, table) {
  // What is forecast tick by tick may go astray; the arm and the ball must not be small for it.
  const paths = arm ? arm.links.map(inThrees) : Object.values(forecasts).map(([one]) => one.position);
  return extentOf([...tablePoints(table), ...measured.position, ...ball.position, ...paths.flat()]);
}

function measuredMarks(view) {
  const { paint, scene, time } = view;
  const { t, position } = scene.measured;
  return position.map((point, index) => {
    const shown = t[index] <= (scene.seen ?? scene.end); // to the predictors
    return dotMark(view, point, paint(shown ? "--ink" : "--page"), t[index] <= time ? 1 : 0.25);
  });
}

function forecastMarks(view, { t, position }, colour) {
  const reached = view.time + view.scene.judged.ahead;
  return pathMarks(view, position, colour, (index) => (t[index] <= reached ? 1 : 0.3));
}

/** The arm: its links as bars, its racket as a disc with a rim. */
function armMarks({ context, project, paint, table, scene, time }) {
  if (!scene.arm) return [];
  const { t, links, normal } = scene.arm;
  const now = Math.min(time, t.at(-1));
  const joints = inThrees(positionAt(t, links, now));
  const facing = positionAt(t, normal, now);
  const bars = joints.slice(1).map((end, index) => {
    const places = [joints[index], end].map(project);
    const width = Math.max((index === 2 ? 0.03 : 0.06) * places[0].scale, 2);
    const draw = () => line(context, places, paint("--arm"), width);
    return { depth: (places[0].depth + places[1].depth) / 2, height: 0, draw };
  });
  const foot = [joints[0], [...joints[0].slice(0, 2), -0.3]].map(project);
  const post = () => line(context, foot, paint("--arm"), Math.max(0.1 * foot[0].scale, 3));
  const rim = racketRim(joints.at(-1), facing, table.racket_radius).map(project);
  const racket = () => {
    area(context, rim, paint("--bad"), 0.85);
    line(context, [...rim, rim[0]], paint("--ink"), 1.2);
  };
  const depth = project(joints.at(-1)).depth;
  return [...bars, { depth: foot[0].depth, height: 0, draw: post }, { depth, height: 0, draw: racket }];
}

/** Points of a circle about a centre, square to a direction. */
function racketRim(centre, direction, radius) {
  const across = [direction[1], -direction[0], 0];
  const side = scaled(across, 1 / Math.hypot(...across));
  const unit = scaled(direction, 1 / Math.hypot(...direction));
  const up = [
    side[1] * unit[2] - side[2] * unit[1],
    side[2] * unit[0] - side[0] * unit[2],
    side[0] * unit[1] - side[1] * unit[0],
  ];
  return ANGLES.map((angle) =>
    add(centre, add(scaled(side, radius * Math.cos(angle)), scaled(up, radius * Math.sin(angle)))));
}

/** The ball where a path has it at an instant; nothing outside of the path. */
function ballMarks(view, { t, position }, instant, fill, stroke) {
  const ball = positionAt(t, position, instant);
  return ball ? [ballMark(view, ball, fill, stroke)] : [];
}

function allMarks(view) {
  const { scene, paint, colours, names, time } = view;
  const forecasts = names.flatMap((name) => {
    const forecast = inForce(scene.forecasts[name], Math.min(time, scene.judged.until));
    if (!forecast) return [];
    const expected = time + scene.judged.ahead;
    const path = forecastMarks(view, forecast, colours[name]);
    return [...path, ...ballMarks(view, forecast, expected, colours[name], paint("--page"))];
  });
  const ball = ballMarks(view, scene.ball, time, paint("--ball"), paint("--ink"));
  return [...measuredMarks(view), ...forecasts, ...ball, ...netMarks(view), ...armMarks(view)];
}

/** Draws `scene` at `time` with the forecasts of the predictors `names`. */
function drawScene(canvas, { scene, time, names, camera, extent, table, colours }) {
  const view = { ...emptied(canvas, { camera, extent, table }), colours, scene, time, names };
  drawWithTable(view, allMarks(view), positionAt(scene.ball.t, scene.ball.position, time));
}
