// The 3-D view: which shot, which instant, from where; scene.js draws it.

const SLOW_MOTION = 0.2; // of the real speed
const START = { yaw: -0.55, pitch: 0.45, zoom: 1 }; // radians
const TURNS = {
  ArrowLeft: [-0.08, 0], ArrowRight: [0.08, 0], ArrowUp: [0, 0.06], ArrowDown: [0, -0.06],
  "+": [0, 0, 1.1], "-": [0, 0, 1 / 1.1],
};

const byId = (id) => document.getElementById(id);
const { shots, colours, table } = JSON.parse(byId("shot-data").textContent);
const canvas = byId("shot-view");
const [picker, playButton, slider] = [byId("shot-picker"), byId("shot-play"), byId("shot-time")];
const [clock, legend] = [byId("shot-clock"), byId("shot-legend")];

let camera = { ...START };
let shot, extent, time;
let playing = false;
const hidden = new Set(); // predictors

function draw() {
  const names = Object.keys(shot.forecasts).filter((name) => !hidden.has(name));
  drawScene(canvas, { shot, time, names, camera, extent, table, colours });
}

// --- the instant ---
const forecastEnd = () =>
  Math.max(shot.anchor, ...Object.values(shot.forecasts).map(({ t }) => t.at(-1)));
const lastInstant = () => Math.max(shot.t.at(-1), forecastEnd());

function setTime(instant) {
  time = Math.min(Math.max(instant, shot.t[0]), lastInstant());
  const milliseconds = Math.round((time - shot.anchor) * 1000);
  slider.value = milliseconds;
  clock.value = `${milliseconds < 0 ? "−" : "+"}${Math.abs(milliseconds)} ms`;
  slider.setAttribute("aria-valuetext", `${clock.value} from the start of the forecast`);
  const ball = positionAt(shot.t, shot.measured, time);
  for (const output of legend.querySelectorAll("output")) {
    const { t, position } = shot.forecasts[output.name];
    const forecast = positionAt(t, position, time);
    output.value = ball && forecast ? `${(distance(ball, forecast) * 1000).toFixed(0)} mm` : "–";
  }
  draw();
}

function play(wanted) {
  playing = wanted;
  playButton.textContent = playing ? "Pause" : "Play";
  if (!playing) return;
  if (time >= lastInstant()) setTime(shot.t[0]);
  let before = performance.now();
  requestAnimationFrame(function step(now) {
    if (!playing) return;
    setTime(time + (Math.max(now - before, 0) / 1000) * SLOW_MOTION);
    before = now;
    if (time < lastInstant()) requestAnimationFrame(step);
    else play(false);
  });
}

// --- the shot and its legend ---
function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

function legendEntry(name) {
  const box = element("input", { type: "checkbox", checked: !hidden.has(name) });
  box.addEventListener("change", () => {
    hidden[box.checked ? "delete" : "add"](name);
    draw();
  });
  const swatch = element("span", { className: "swatch" });
  swatch.style.background = colours[name];
  return element("label", {}, box, swatch, name, element("output", { name }));
}

function show(index) {
  shot = shots[index];
  extent = extentOf(shot, table);
  const measured = element("span", {}, element("span", { className: "dot" }), "measured");
  legend.replaceChildren(measured, ...Object.keys(shot.forecasts).map(legendEntry));
  slider.min = Math.round((shot.t[0] - shot.anchor) * 1000);
  slider.max = Math.round((lastInstant() - shot.anchor) * 1000);
  setTime(Math.min(forecastEnd(), shot.t.at(-1)));
}

// --- the camera ---
function turn(yaw, pitch, zoom = 1) {
  camera.yaw += yaw;
  camera.pitch = Math.min(Math.max(camera.pitch + pitch, 0.03), Math.PI / 2);
  camera.zoom = Math.min(Math.max(camera.zoom * zoom, 0.4), 8);
  draw();
}

const fingers = new Map(); // pointer id -> where it last was; a mouse is one finger
const spread = ([a, b]) => Math.hypot(a.clientX - b.clientX, a.clientY - b.clientY);

canvas.addEventListener("pointerdown", (event) => {
  canvas.setPointerCapture(event.pointerId);
  fingers.set(event.pointerId, event);
});
canvas.addEventListener("pointermove", (event) => {
  const last = fingers.get(event.pointerId);
  if (!last) return;
  const before = [...fingers.values()];
  fingers.set(event.pointerId, event);
  if (before.length === 2) turn(0, 0, spread([...fingers.values()]) / spread(before));
  else turn(-0.008 * (event.clientX - last.clientX), 0.006 * (event.clientY - last.clientY));
});
for (const end of ["pointerup", "pointercancel"]) {
  canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
}
canvas.addEventListener("wheel", (event) => {
  if (!event.ctrlKey) return; // a plain wheel scrolls the page
  event.preventDefault();
  turn(0, 0, Math.exp(-0.002 * event.deltaY));
}, { passive: false });
canvas.addEventListener("keydown", (event) => {
  if (!(event.key in TURNS)) return;
  event.preventDefault();
  turn(...TURNS[event.key]);
});
canvas.addEventListener("dblclick", () => {
  camera = { ...START };
  draw();
});

picker.addEventListener("change", () => {
  play(false);
  show(picker.selectedIndex);
});
playButton.addEventListener("click", () => play(!playing));
slider.addEventListener("input", () => {
  play(false);
  setTime(shot.anchor + slider.valueAsNumber / 1000);
});
show(0);
for (const media of ["(prefers-color-scheme: dark)", "print"]) {
  matchMedia(media).addEventListener("change", draw); // other colours
}
new ResizeObserver(draw).observe(canvas);
