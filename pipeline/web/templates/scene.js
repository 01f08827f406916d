// Draws one scene at one instant, seen from a camera, onto a plain 2-D canvas.

const LINE_WIDTH = 0.02; // m, of the white lines along the table's edges
const BELOW_TABLE = -0.05; // m; a centre under this is under the table, not in it

const add = (a, b) => a.map((value, axis) => value + b[axis]);
const scaled = (a, factor) => a.map((value) => value * factor);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const distance = (a, b) => Math.hypot(...add(a, scaled(b, -1)));

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
function extentOf({ measured, ball, forecasts, arm }, table) {
  const { half_width: w, half_length: l, net_height, net_overhang } = table;
  const corners = [[-w, -l, 0], [w, -l, 0], [w, l, 0], [-w, l, 0]];
  const net = [-w - net_overhang, w + net_overhang].map((x) => [x, 0, net_height]);
  // What is forecast tick by tick may go astray; the arm and the ball must not be small for it.
  const paths = arm ? arm.links.map(inThrees) : Object.values(forecasts).map(([one]) => one.position);
  const points = [...corners, ...net, ...measured.position, ...ball.position, ...paths.flat()];
  const low = [0, 1, 2].map((axis) => Math.min(...points.map((point) => point[axis])));
  const high = [0, 1, 2].map((axis) => Math.max(...points.map((point) => point[axis])));
  return { points, middle: scaled(add(low, high), 0.5), size: distance(low, high) };
}

/** A function from points (m) to pixels; the camera stands off in direction (yaw, pitch). */
function projection(canvas, camera, extent) {
  const [cy, sy] = [Math.cos(camera.yaw), Math.sin(camera.yaw)];
  const [cp, sp] = [Math.cos(camera.pitch), Math.sin(camera.pitch)];
  const [right, up, towards] = [[-sy, cy, 0], [-sp * cy, -sp * sy, cp], [cp * cy, cp * sy, sp]];
  const flat = (point) => {
    const place = add(point, scaled(extent.middle, -1));
    const depth = 1.6 * extent.size - dot(place, towards);
    return { x: dot(place, right) / depth, y: -dot(place, up) / depth, depth };
  };
  const seen = extent.points.map(flat);
  const [x, y] = ["x", "y"].map((axis) => {
    const values = seen.map((place) => place[axis]);
    const [low, high] = [Math.min(...values), Math.max(...values)];
    return { middle: (low + high) / 2, extent: high - low };
  });
  const { clientWidth: width, clientHeight: height } = canvas;
  const focal = 0.9 * camera.zoom * Math.min(width / x.extent, height / y.extent);
  return (point) => {
    const place = flat(point);
    return {
      x: width / 2 + focal * (place.x - x.middle),
      y: height / 2 + focal * (place.y - y.middle),
      depth: place.depth,
      scale: focal / place.depth, // pixels a metre, where the point is
    };
  };
}

function line(context, places, colour, width, alpha = 1) {
  Object.assign(context, { globalAlpha: alpha, strokeStyle: colour, lineWidth: width });
  context.beginPath();
  places.forEach(({ x, y }) => context.lineTo(x, y));
  context.stroke();
}

function area(context, places, colour, alpha = 1) {
  Object.assign(context, { globalAlpha: alpha, fillStyle: colour });
  context.beginPath();
  places.forEach(({ x, y }) => context.lineTo(x, y));
  context.fill();
}

function disc(context, { x, y }, radius, fill, stroke, alpha = 1) {
  Object.assign(context, { globalAlpha: alpha, fillStyle: fill, strokeStyle: stroke, lineWidth: 1.2 });
  context.beginPath();
  context.arc(x, y, radius, 0, 2 * Math.PI);
  context.fill();
  context.stroke();
}

function drawTable({ context, project, paint, table }) {
  const { half_width: w, half_length: l } = table;
  const ring = (x, y) => [[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]].map(project);
  area(context, ring(w, l), paint("--line"));
  area(context, ring(w - LINE_WIDTH, l - LINE_WIDTH), paint("--table"));
  line(context, [...ring(w, l), project([-w, -l, 0])], paint("--edge"), 1);
  line(context, [[0, -l, 0], [0, l, 0]].map(project), paint("--line"), 0.8, 0.7);
}

function drawShadow({ context, project, paint, table }, ball) {
  const over = Math.abs(ball[0]) < table.half_width && Math.abs(ball[1]) < table.half_length;
  if (!over || ball[2] < 0) return;
  const foot = [ball[0], ball[1], 0];
  const rim = Array.from({ length: 24 }, (_, k) => (k * Math.PI) / 12).map((angle) =>
    add(foot, scaled([Math.cos(angle), Math.sin(angle), 0], 1.4 * table.ball_radius)));
  area(context, rim.map(project), paint("--ink"), 0.35);
  line(context, [project(foot), project(ball)], paint("--ink"), 0.8, 0.4);
}

// What stands or flies is cut into marks, which are drawn from the farthest to the nearest.

function netMarks({ context, project, paint, table }) {
  const edge = table.half_width + table.net_overhang;
  const strips = 16;
  return Array.from({ length: strips }, (_, strip) => {
    const [left, right] = [strip, strip + 1].map((k) => -edge + (2 * edge * k) / strips);
    const top = [[left, 0, table.net_height], [right, 0, table.net_height]].map(project);
    const foot = [[right, 0, 0], [left, 0, 0]].map(project);
    const draw = () => {
      area(context, [...top, ...foot], paint("--net"), 0.28);
      line(context, [top[1], foot[0]], paint("--net"), 0.6, 0.5);
      line(context, top, paint("--line"), 2.2);
    };
    return { depth: foot[0].depth, height: 0, draw };
  });
}

function measuredMarks({ context, project, paint, canvas, scene, time }) {
  const radius = 1.3 + canvas.clientWidth / 800;
  const { t, position } = scene.measured;
  return position.map((point, index) => {
    const place = project(point);
    const shown = t[index] <= (scene.seen ?? scene.end); // to the predictors
    const fill = shown ? paint("--ink") : paint("--page");
    const alpha = t[index] <= time ? 1 : 0.25;
    const draw = () => disc(context, place, radius, fill, paint("--ink"), alpha);
    return { depth: place.depth, height: point[2], draw };
  });
}

function forecastMarks({ context, project, time, scene }, { t, position }, colour) {
  const places = position.map(project);
  return places.slice(1).map((place, index) => {
    const alpha = t[index + 1] <= time + scene.judged.ahead ? 1 : 0.3;
    const draw = () => line(context, [places[index], place], colour, 2.4, alpha);
    return { depth: place.depth, height: position[index + 1][2], draw };
  });
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
  return Array.from({ length: 24 }, (_, k) => (k * Math.PI) / 12).map((angle) =>
    add(centre, add(scaled(side, radius * Math.cos(angle)), scaled(up, radius * Math.sin(angle)))));
}

function ballMarks({ context, project, table }, { t, position }, instant, fill, stroke) {
  const ball = positionAt(t, position, instant);
  if (!ball) return [];
  const place = project(ball);
  const radius = Math.max(table.ball_radius * place.scale, 4.5);
  const draw = () => disc(context, place, radius, fill, stroke);
  return [{ depth: place.depth - 2 * table.ball_radius, height: ball[2], draw }];
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
  const marks = [...measuredMarks(view), ...forecasts, ...ball, ...netMarks(view), ...armMarks(view)];
  return marks.sort((a, b) => b.depth - a.depth);
}

/** Draws `scene` at `time` with the forecasts of the predictors `names`. */
function drawScene(canvas, { scene, time, names, camera, extent, table, colours }) {
  const ratio = window.devicePixelRatio || 1;
  canvas.width = Math.round(canvas.clientWidth * ratio); // setting the size clears the canvas
  canvas.height = Math.round(canvas.clientHeight * ratio);
  const context = canvas.getContext("2d");
  context.scale(ratio, ratio);
  context.lineCap = context.lineJoin = "round";
  const style = getComputedStyle(canvas);
  const paint = (name) => style.getPropertyValue(name);
  const project = projection(canvas, camera, extent);
  const view = { canvas, context, project, paint, table, colours, scene, time, names };
  const marks = allMarks(view);
  marks.filter((mark) => mark.height < BELOW_TABLE).forEach((mark) => mark.draw());
  drawTable(view);
  const ball = positionAt(scene.ball.t, scene.ball.position, time);
  if (ball) drawShadow(view, ball);
  marks.filter((mark) => mark.height >= BELOW_TABLE).forEach((mark) => mark.draw());
}
