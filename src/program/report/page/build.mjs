// build.mjs FOLDER: bundles the page with the libraries in FOLDER/node_modules into FOLDER/html_page_template.cpp.
import { readFileSync, writeFileSync } from "node:fs";
import { createRequire } from "node:module";
import { dirname, join, resolve } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const folder = resolve(process.argv[2]);
const modules = join(folder, "node_modules");
const esbuild = createRequire(join(folder, "package.json"))("esbuild-wasm");

const bundle = async (entry) => {
  const result = await esbuild.build({
    entryPoints: [entry], bundle: true, minify: true, write: false, format: "iife", target: "es2022",
    charset: "utf8", legalComments: "inline", nodePaths: [modules],
  });
  return result.outputFiles[0].text;
};

const text = (path) => readFileSync(path, "utf8");
const licence = (name) => `${name} ${JSON.parse(text(join(modules, name, "package.json"))).version}\n\n` +
  text(join(modules, name, "LICENSE")).trim();
const escape = (plain) => plain.replace(/[&<>]/g, (c) => ({ "&": "&amp;", "<": "&lt;", ">": "&gt;" })[c]);

const parts = {
  "/*style*/": text(join(modules, "uplot", "dist", "uPlot.min.css")) + (await bundle(join(here, "page.css"))),
  "<!--licences-->": escape(["three", "uplot"].map(licence).join("\n\n\n")),
  "/*script*/": (await bundle(join(here, "main.ts"))).replaceAll("</script", "<\\/script"),
};
let page = text(join(here, "page.html"));
for (const [place, part] of Object.entries(parts)) page = page.split(place).join(part);

// Compilers bound the length of one literal: bytes as numbers have no such bound and need no escapes.
const bytes = Buffer.from(page, "utf8");
const rows = [];
for (let k = 0; k < bytes.length; k += 64) rows.push(Array.from(bytes.subarray(k, k + 64), (b) => (b << 24) >> 24).join(","));
writeFileSync(join(folder, "html_page_template.cpp"), `#include "report/html_page.hpp"
namespace tanor::report {
static constexpr char page[] = {
${rows.join(",\n")}};
std::string_view html_page_template() { return {page, sizeof page}; }
}  // namespace tanor::report
`);
