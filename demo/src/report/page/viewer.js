"use strict";

const STEP = 2, LARGE_STEP = 10; // percent that an arrow key moves the divider, without and with Shift

function viewer(section) {
  const stage = section.querySelector(".stage");
  const [flipButton, slideButton, mark] = [".flip", ".slide", ".mark"].map((name) => section.querySelector(name));
  const overlay = stage.querySelector("svg");
  let at = 50;
  let flipped = null; // null: the slider; else the side that is shown

  const chosen = (name) => section.querySelector(`input[name="${section.id}-${name}"]:checked`).value;

  function show() {
    const frame = section.querySelector(`.moment[data-frame="${chosen("frame")}"]`);
    for (const other of section.querySelectorAll(".moment")) other.hidden = other !== frame;
    for (const side of ["left", "right"]) {
      const image = frame.querySelector(`img[data-image="${chosen(side)}"]`);
      stage.querySelector(`img.${side}`).src = image.src;
      stage.querySelector(`.tag.${side}`).textContent = image.alt;
      section.querySelector(`.numbers.${side}`).textContent = image.dataset.numbers;
    }
    drawCrops(frame);
    overlay.replaceChildren(...[...frame.querySelectorAll(".strip")].flatMap(outline));
    overlay.toggleAttribute("hidden", !mark.checked);
  }

  function move(percent) {
    at = Math.min(100, Math.max(0, percent));
    stage.style.setProperty("--at", `${at}%`);
    stage.setAttribute("aria-valuenow", Math.round(at));
  }

  function setFlipped(side) {
    flipped = side;
    stage.classList.toggle("flipping", side !== null);
    stage.classList.toggle("show-left", side === "left");
    stage.classList.toggle("show-right", side === "right");
    flipButton.setAttribute("aria-pressed", side !== null);
    slideButton.setAttribute("aria-pressed", side === null);
  }

  const flip = () => setFlipped(flipped === "right" ? "left" : "right");
  const slide = () => setFlipped(null);

  function follow(event) {
    const box = stage.getBoundingClientRect();
    move((100 * (event.clientX - box.left)) / box.width);
  }

  stage.addEventListener("pointerdown", (event) => {
    if (flipped !== null) return flip();
    stage.setPointerCapture(event.pointerId);
    follow(event);
  });
  stage.addEventListener("pointermove", (event) => {
    if (stage.hasPointerCapture(event.pointerId)) follow(event);
  });
  stage.addEventListener("keydown", (event) => {
    const step = event.shiftKey ? LARGE_STEP : STEP;
    const to = { ArrowLeft: at - step, ArrowRight: at + step, Home: 0, End: 100 }[event.key];
    if (to === undefined) return;
    event.preventDefault();
    slide();
    move(to);
  });
  flipButton.addEventListener("click", flip);
  slideButton.addEventListener("click", slide);
  section.querySelector(".panel").addEventListener("change", show);
  show();
  return { stage, keys: { f: flip, s: slide } };
}

// Each strip shows the same part of all images.
async function drawCrops(frame) {
  for (const canvas of frame.querySelectorAll("canvas")) {
    const image = frame.querySelector(`img[data-image="${canvas.dataset.image}"]`);
    await image.decode();
    canvas.getContext("2d").drawImage(image, -canvas.dataset.x, -canvas.dataset.y);
  }
}

function outline(strip) {
  const { width, height, dataset } = strip.querySelector("canvas");
  const element = (name, attributes) => {
    const node = document.createElementNS("http://www.w3.org/2000/svg", name);
    for (const [key, value] of Object.entries(attributes)) node.setAttribute(key, value);
    return node;
  };
  const text = element("text", { x: +dataset.x + 3, y: +dataset.y + 10, "font-size": 9 });
  text.textContent = strip.dataset.crop;
  return [element("rect", { x: dataset.x, y: dataset.y, width, height }), text];
}

const viewers = [...document.querySelectorAll(".stretch")].map(viewer);

// Keys work without focus, on the comparison that is nearest to the middle of the window.
document.addEventListener("keydown", (event) => {
  if (event.ctrlKey || event.altKey || event.metaKey) return;
  const away = ({ stage }) => {
    const box = stage.getBoundingClientRect();
    return Math.abs(box.top + box.bottom - window.innerHeight);
  };
  const nearest = viewers.reduce((best, other) => (away(other) < away(best) ? other : best));
  nearest.keys[event.key.toLowerCase()]?.();
});
