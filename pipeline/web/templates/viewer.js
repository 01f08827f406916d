// A 3-D view: which scene and which instant; camera.js says from where, scene.js draws it.

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

  let scene, extent, time;
  let playing = false;
  const hidden = new Set(); // predictors
  const camera = cameraOf(canvas, draw);

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
    extent = sceneExtent(scene, table);
    const measured = element("span", {}, element("span", { className: "dot" }), "measured");
    legend.replaceChildren(measured, ...Object.keys(scene.forecasts).map(legendEntry));
    slider.min = Math.round((scene.start - scene.zero) * 1000);
    slider.max = Math.round((scene.end - scene.zero) * 1000);
    setTime(scene.shown);
  }

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
  drawAgain(canvas, draw);
}

for (const box of document.querySelectorAll(".viewer")) view(box.id);
