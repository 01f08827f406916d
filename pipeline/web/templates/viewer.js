// A 3-D view: which scene, which instant, from where; scene.js draws it.

const START = { yaw: -0.55, pitch: 0.45, zoom: 1 }; // radians
const TURNS = {
  ArrowLeft: [-0.08, 0], ArrowRight: [0.08, 0], ArrowUp: [0, 0.06], ArrowDown: [0, -0.06],
  "+": [0, 0, 1.1], "-": [0, 0, 1 / 1.1],
};

function element(tag, properties = {}, ...children) {
  const made = Object.assign(document.createElement(tag), properties);
  made.append(...children);
  return made;
}

/** The forecast that holds at an instant: the last that was made by then, or null. */
const inForce = (forecasts, instant) =>
  forecasts.findLast((forecast) => forecast.from <= instant + 1e-9) ?? null;

function view(id) {
  const byId = (part) => document.getElementById(`${id}-${part}`);
  const { scenes, colours, table } = JSON.parse(byId("data").textContent);
  const [canvas, picker, playButton, slider] = ["view", "picker", "play", "time"].map(byId);
  const [clock, legend, speed] = ["clock", "legend", "speed"].map(byId);

  let camera = { ...START };
  let scene, extent, time;
  let playing = false;
  const hidden = new Set(); // predictors

  function draw() {
    const names = Object.keys(scene.forecasts).filter((name) => !hidden.has(name));
    drawScene(canvas, { scene, time, names, camera, extent, table, colours });
  }

  // --- the instant ---
  function distanceOff(forecasts) {
    const { ahead, until } = scene.judged;
    const forecast = time + ahead <= until ? inForce(forecasts, time) : null;
    const expected = forecast && positionAt(forecast.t, forecast.position, time + ahead);
    const ball = positionAt(scene.ball.t, scene.ball.position, time + ahead);
    return ball && expected ? `${(distance(ball, expected) * 1000).toFixed(0)} mm` : "–";
  }

  function setTime(instant) {
    time = Math.min(Math.max(instant, scene.start), scene.end);
    const milliseconds = Math.round((time - scene.zero) * 1000);
    slider.value = milliseconds;
    clock.value = `${milliseconds < 0 ? "−" : "+"}${Math.abs(milliseconds)} ms`;
    slider.setAttribute("aria-valuetext", clock.value);
    for (const output of legend.querySelectorAll("output")) {
      output.value = distanceOff(scene.forecasts[output.name]);
    }
    draw();
  }

  function play(wanted) {
    playing = wanted;
    playButton.textContent = playing ? "Pause" : "Play";
    if (!playing) return;
    if (time >= scene.end) setTime(scene.start);
    let before = performance.now();
    requestAnimationFrame(function step(now) {
      if (!playing) return;
      setTime(time + (Math.max(now - before, 0) / 1000) * Number(speed.value));
      before = now;
      if (time < scene.end) requestAnimationFrame(step);
      else play(false);
    });
  }

  // --- the scene and its legend ---
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
    scene = scenes[index];
    extent = extentOf(scene, table);
    const measured = element("span", {}, element("span", { className: "dot" }), "measured");
    legend.replaceChildren(measured, ...Object.keys(scene.forecasts).map(legendEntry));
    slider.min = Math.round((scene.start - scene.zero) * 1000);
    slider.max = Math.round((scene.end - scene.zero) * 1000);
    setTime(scene.shown);
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
    setTime(scene.zero + slider.valueAsNumber / 1000);
  });
  show(0);
  for (const media of ["(prefers-color-scheme: dark)", "print"]) {
    matchMedia(media).addEventListener("change", draw); // other colours
  }
  new ResizeObserver(draw).observe(canvas);
}

for (const box of document.querySelectorAll(".viewer")) view(box.id);
