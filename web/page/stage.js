// What one does to the frame with pointer and keys.

/** Turns the camera with the pointer, the wheel and the keys. */
export function listen_to_stage(stage, look) {
  stage.addEventListener("pointermove", (event) => {
    if (event.buttons & 1) look(-event.movementX / 200, -event.movementY / 200, 1);
  });
  stage.addEventListener("pointerdown", (event) => stage.setPointerCapture(event.pointerId));
  stage.addEventListener("wheel", (event) => {
    event.preventDefault();
    look(0, 0, Math.exp(event.deltaY / 1000));
  }, { passive: false });
  const keys = { ArrowLeft: [0.1, 0, 1], ArrowRight: [-0.1, 0, 1], ArrowUp: [0, -0.1, 1], ArrowDown: [0, 0.1, 1], "+": [0, 0, 0.9], "-": [0, 0, 1.1] };
  stage.addEventListener("keydown", (event) => {
    if (!keys[event.key]) return;
    event.preventDefault();
    look(...keys[event.key]);
  });
}

/** Takes a file that is dropped on the page: `take` gets its bytes and its name. */
export function listen_to_drops(take) {
  for (const name of ["dragover", "drop"]) document.addEventListener(name, (event) => event.preventDefault());
  document.addEventListener("drop", async (event) => {
    const [file] = event.dataTransfer.files;
    if (file) await take(await file.arrayBuffer(), file.name);
  });
}
