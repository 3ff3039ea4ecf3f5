// The browser that tests drive: Debian's, or one that Playwright has installed, with WebGPU in software.
import { existsSync, realpathSync } from "node:fs";
import { dirname, join } from "node:path";
import { chromium } from "playwright-core";

const PLACES = ["/usr/bin/chromium", "/usr/bin/chromium-browser", "/usr/bin/google-chrome"];

// On a machine without a GPU, WebGPU is SwiftShader's, and has to be asked for.
const FLAGS = [
  "--no-sandbox", "--enable-unsafe-webgpu", "--use-webgpu-adapter=swiftshader", "--enable-features=Vulkan",
];

/** The browser's program: the one that UMBRAGRAPH_BROWSER names, or the first that is installed. */
export function program() {
  const named = process.env.UMBRAGRAPH_BROWSER;
  const places = named ? [named] : [chromium.executablePath(), ...PLACES];
  return places.find((place) => place && existsSync(place));
}

/** The Vulkan driver that comes with a browser, so that the command draws on the same one. */
export function driver(program) {
  const folders = [dirname(realpathSync(program)), "/usr/lib/chromium", "/usr/lib/chromium-browser", "/opt/google/chrome"];
  return folders.map((folder) => join(folder, "vk_swiftshader_icd.json")).find((file) => existsSync(file));
}

/** Starts the browser without a window. */
export function start(program) {
  return chromium.launch({ executablePath: program, headless: true, args: FLAGS });
}
