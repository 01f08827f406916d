// The camera of a 3-D view, which a mouse, fingers and keys turn.

const START = { yaw: -0.55, pitch: 0.45, zoom: 1 }; // radians
const TURNS = {
  ArrowLeft: [-0.08, 0], ArrowRight: [0.08, 0], ArrowUp: [0, 0.06], ArrowDown: [0, -0.06],
  "+": [0, 0, 1.1], "-": [0, 0, 1 / 1.1],
};

/** The camera of a canvas, which `draw` draws when the camera has been turned. */
function cameraOf(canvas, draw) {
  const camera = { ...START };

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
    Object.assign(camera, START);
    draw();
  });
  return camera;
}

/** Draws a canvas again whenever its size or its colours change. */
function drawAgain(canvas, draw) {
  for (const media of ["(prefers-color-scheme: dark)", "print"]) {
    matchMedia(media).addEventListener("change", draw); // other colours
  }
  new ResizeObserver(draw).observe(canvas);
}
