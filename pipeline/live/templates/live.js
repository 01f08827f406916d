// The live view: events bring pictures, of which the latest is drawn; camera.js says from where.

const NONE = "–";
const ROOM = { beyond: 0.5, above: 0.6 }; // m, about the table, that a picture holds

const byId = (id) => document.getElementById(id);
const canvas = byId("live-view");
const { table } = JSON.parse(byId("live-data").textContent);
const extent = extentOf([...tablePoints(table), ...roomPoints(table)]);
const camera = cameraOf(canvas, draw);
let picture = null; // the latest
let due = false; // whether it is drawn with the next frame of the screen

/** Corners of the room in which balls fly. */
function roomPoints({ half_width, half_length }) {
  const [x, y] = [half_width, half_length + ROOM.beyond];
  return [[-x, -y], [x, -y], [x, y], [-x, y]].map((corner) => [...corner, ROOM.above]);
}

// --- the picture ---

/** The outline of an ellipsoid x' M^-1 x <= 1 about a centre, seen from the camera; M in mm^2. */
function outlineOf(centre, [xx, xy, xz, yy, yz, zz], { right, up }) {
  return ANGLES.map((angle) => {
    const way = add(scaled(right, Math.cos(angle)), scaled(up, Math.sin(angle)));
    const reached = [[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]].map((row) => dot(row, way));
    const size = Math.sqrt(Math.max(dot(way, reached), 1e-9)); // mm, in this direction
    return add(centre, scaled(reached, 1e-3 / size));
  });
}

function setMarks({ context, project, paint, camera }, centres, sets) {
  const axes = axesOf(camera);
  return sets.map((set, index) => {
    const outline = outlineOf(centres[index], set, axes).map(project);
    const draw = () => area(context, outline, paint("--accent"), 0.18);
    return { depth: project(centres[index]).depth, height: centres[index][2], draw };
  });
}

function bounceMark({ context, project, paint, table }, [x, y]) {
  const rim = ring([x, y, 0], 2 * table.ball_radius).map(project);
  const draw = () => {
    area(context, rim, paint("--good"), 0.3);
    line(context, [...rim, rim[0]], paint("--good"), 2);
  };
  return { depth: project([x, y, 0]).depth, height: 0, draw };
}

function ballMarks(view, { forecast, about }) {
  const { paint } = view;
  const ball = about.measured.at(-1);
  const positions = forecast.states.map((state) => state.slice(0, 3));
  return [
    ...about.measured.map((point) => dotMark(view, point, paint("--ink"), 0.6)),
    ...setMarks(view, positions, about.sets),
    ...pathMarks(view, [ball, ...positions], paint("--accent"), () => 1),
    ...(forecast.bounce ? [bounceMark(view, forecast.bounce.state)] : []),
    ballMark(view, ball, paint("--ball"), paint("--ink")),
  ];
}

/** Whether there is a ball, of which the forecast is not wholly in the past. */
const hasBall = () => picture !== null && picture.about.sets.length > 0;

function draw() {
  const view = emptied(canvas, { camera, extent, table });
  const marks = hasBall() ? ballMarks(view, picture) : [];
  const ball = hasBall() ? picture.about.measured.at(-1) : null;
  drawWithTable(view, [...marks, ...netMarks(view)], ball);
}

// --- the numbers ---

function bounceText({ time, bounce }) {
  if (!bounce) return NONE;
  const [x, y] = bounce.state.map((value) => value.toFixed(2).replace("-", "−"));
  const after = ((bounce.time - time) / 1e6).toFixed(0); // ns to ms, from the last measurement
  const error = (1e3 * bounce.time_error).toFixed(1);
  return `in ${after} ms, standard error ${error} ms, at x = ${x} m, y = ${y} m`;
}

function errorText({ ahead, position_errors: errors }) {
  const middle = errors.length / 3 - 1;
  const text = (index) =>
    `${(1e3 * Math.hypot(...errors[index])).toFixed(1)} mm in ${(1e3 * ahead[index]).toFixed(0)} ms`;
  return `${text(middle)}, ${text(errors.length - 1)} (root mean square)`;
}

function write({ forecast, about }) {
  byId("frame").textContent = `${forecast.num}: ${forecast.seen}`;
  byId("bounce").textContent = hasBall() ? bounceText(forecast) : NONE;
  byId("error").textContent = hasBall() ? errorText(forecast) : NONE;
  const { 50: p50, 99: p99 } = about.latency;
  byId("latency").textContent = `${p50} ms (p50), ${p99} ms (p99) of ${about.frames} frames`;
  const alarm = byId("alarm");
  if (alarm.textContent === (about.alarm ?? "")) return; // screen readers read every change
  alarm.textContent = about.alarm ?? "";
  alarm.hidden = !about.alarm;
}

// --- the events ---

function say(state) {
  byId("state").textContent = state;
}

function showSoon() {
  if (due) return;
  due = true;
  requestAnimationFrame(() => {
    due = false;
    write(picture);
    draw();
  });
}

const events = new EventSource("events");
events.addEventListener("open", () => say("Connected; no frame yet."));
events.addEventListener("error", () => say("Not connected: rallygap live has ended, or cannot be reached."));
events.addEventListener("message", ({ data }) => {
  picture = JSON.parse(data);
  say(hasBall() ? "A ball is measured." : "No ball.");
  showSoon();
});
drawAgain(canvas, draw);
