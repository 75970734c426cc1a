// Gives shaders to Tint, the WGSL compiler of Chromium: node tint.mjs FOLDER, with `webgpu` installed in FOLDER.
//
// Each line on stdin is a shader: NAME, WGSL file, `compute` or `render`, entry points, values of overrides (NAME=VALUE,
// separated by commas), separated by tabs. Each line on stdout is NAME and what Tint says against it, nothing where all is well.
//
// Dawn's null backend needs neither a driver nor a GPU, and holds shaders against WebGPU's default limits.
import { createInterface } from "node:readline";
import { readFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { pathToFileURL } from "node:url";

const package_ = join(resolve(process.argv[2]), "node_modules", "webgpu", "index.js");
const { create } = await import(pathToFileURL(package_));
// Dawn's objects do not keep each other alive: what is unreachable is gone at the next garbage collection.
globalThis.gpu = create(["backend=null"]);
globalThis.adapter = await gpu.requestAdapter();
const device = await adapter.requestDevice();

const pipelines = {
    compute: ([entryPoint], stage) => device.createComputePipelineAsync({
        layout: "auto",
        compute: { ...stage, entryPoint },
    }),
    render: ([vertex, fragment], stage) => device.createRenderPipelineAsync({
        layout: "auto",
        vertex: { ...stage, entryPoint: vertex },
        fragment: { ...stage, entryPoint: fragment, targets: [{ format: "bgra8unorm" }] },
    }),
};

async function complaints(file, kind, entryPoints, constants) {
    device.pushErrorScope("validation");
    const module = device.createShaderModule({ code: readFileSync(file, "utf8") });
    const { messages } = await module.getCompilationInfo();
    const error = await device.popErrorScope();
    const found = messages.filter(({ type }) => type !== "info");
    if (found.length > 0) {
        return found.map(({ type, lineNum, linePos, message }) => `${lineNum}:${linePos} ${type}: ${message}`);
    }
    if (error) return [error.message];
    try {
        await pipelines[kind](entryPoints, { module, constants });
    } catch (error) {
        return [error.message];
    }
    return [];
}

for await (const line of createInterface({ input: process.stdin })) {
    const [name, file, kind, entryPoints, values] = line.split("\t");
    const constants = values.split(",").filter((value) => value).map((value) => value.split("="));
    const found = await complaints(
        file,
        kind,
        entryPoints.split(","),
        Object.fromEntries(constants.map(([name, value]) => [name, Number(value)])),
    );
    console.log(`${name}\t${found.join("; ").replace(/\s+/g, " ")}`);
}
// Dawn would keep the process alive.
process.exit(0);
