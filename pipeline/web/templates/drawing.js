// Draws a table, a net, balls and paths, seen from a camera, onto a plain 2-D canvas.

const LINE_WIDTH = 0.02; // m, of the white lines along the table's edges
const BELOW_TABLE = -0.05; // m; a centre under this is under the table, not in it
const ANGLES = Array.from({ length: 24 }, (_, k) => (k * Math.PI) / 12); // of a rim's points

const add = (a, b) => a.map((value, axis) => value + b[axis]);
const scaled = (a, factor) => a.map((value) => value * factor);
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const distance = (a, b) => Math.hypot(...add(a, scaled(b, -1)));

/** Corners of the table and ends of the net, which every picture holds. */
function tablePoints({ half_width: w, half_length: l, net_height, net_overhang }) {
  const corners = [[-w, -l, 0], [w, -l, 0], [w, l, 0], [-w, l, 0]];
  return [...corners, ...[-w - net_overhang, w + net_overhang].map((x) => [x, 0, net_height])];
}

/** The points that a picture is to hold, their middle and their size. */
function extentOf(points) {
  const low = [0, 1, 2].map((axis) => Math.min(...points.map((point) => point[axis])));
  const high = [0, 1, 2].map((axis) => Math.max(...points.map((point) => point[axis])));
  return { points, middle: scaled(add(low, high), 0.5), size: distance(low, high) };
}

/** Unit vectors to the right of a camera, up, and from the picture's middle to it. */
function axesOf({ yaw, pitch }) {
  const [cy, sy] = [Math.cos(yaw), Math.sin(yaw)];
  const [cp, sp] = [Math.cos(pitch), Math.sin(pitch)];
  return { right: [-sy, cy, 0], up: [-sp * cy, -sp * sy, cp], towards: [cp * cy, cp * sy, sp] };
}

/** A function from points (m) to pixels; the camera stands off in direction (yaw, pitch). */
function projection(canvas, camera, extent) {
  const { right, up, towards } = axesOf(camera);
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
  const outline = (x, y) => [[-x, -y, 0], [x, -y, 0], [x, y, 0], [-x, y, 0]].map(project);
  area(context, outline(w, l), paint("--line"));
  area(context, outline(w - LINE_WIDTH, l - LINE_WIDTH), paint("--table"));
  line(context, [...outline(w, l), project([-w, -l, 0])], paint("--edge"), 1);
  line(context, [[0, -l, 0], [0, l, 0]].map(project), paint("--line"), 0.8, 0.7);
}

/** Points of a level circle about a centre. */
const ring = (centre, radius) =>
  ANGLES.map((angle) => add(centre, scaled([Math.cos(angle), Math.sin(angle), 0], radius)));

function drawShadow({ context, project, paint, table }, ball) {
  const over = Math.abs(ball[0]) < table.half_width && Math.abs(ball[1]) < table.half_length;
  if (!over || ball[2] < 0) return;
  const foot = [ball[0], ball[1], 0];
  area(context, ring(foot, 1.4 * table.ball_radius).map(project), paint("--ink"), 0.35);
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

/** A measured position. */
function dotMark({ context, project, paint, canvas }, point, fill, alpha) {
  const place = project(point);
  const radius = 1.3 + canvas.clientWidth / 800;
  const draw = () => disc(context, place, radius, fill, paint("--ink"), alpha);
  return { depth: place.depth, height: point[2], draw };
}

/** A path, as a mark for each of its pieces; `alphaAt` tells how opaque the one to a point is. */
function pathMarks({ context, project }, points, colour, alphaAt) {
  const places = points.map(project);
  return places.slice(1).map((place, index) => {
    const draw = () => line(context, [places[index], place], colour, 2.4, alphaAt(index + 1));
    return { depth: place.depth, height: points[index + 1][2], draw };
  });
}

function ballMark({ context, project, table }, ball, fill, stroke) {
  const place = project(ball);
  const radius = Math.max(table.ball_radius * place.scale, 4.5);
  const draw = () => disc(context, place, radius, fill, stroke);
  return { depth: place.depth - 2 * table.ball_radius, height: ball[2], draw };
}

/** An empty picture, and what drawing on it needs. */
function emptied(canvas, { camera, extent, table }) {
  const ratio = window.devicePixelRatio || 1;
  canvas.width = Math.round(canvas.clientWidth * ratio); // setting the size clears the canvas
  canvas.height = Math.round(canvas.clientHeight * ratio);
  const context = canvas.getContext("2d");
  context.scale(ratio, ratio);
  context.lineCap = context.lineJoin = "round";
  const style = getComputedStyle(canvas);
  const paint = (name) => style.getPropertyValue(name);
  return { canvas, context, paint, project: projection(canvas, camera, extent), camera, table };
}

/** Draws the table, what is under it and above it, and the shadow of a ball, if there is one. */
function drawWithTable(view, marks, ball) {
  marks.sort((a, b) => b.depth - a.depth);
  marks.filter((mark) => mark.height < BELOW_TABLE).forEach((mark) => mark.draw());
  drawTable(view);
  if (ball) drawShadow(view, ball);
  marks.filter((mark) => mark.height >= BELOW_TABLE).forEach((mark) => mark.draw());
}
