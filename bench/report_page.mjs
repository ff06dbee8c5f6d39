// report_page.mjs PAGE [CHROMIUM]: opens a report.html five times in headless Chromium, which draws without a GPU, and prints
// its size, when its first picture stood (from the request on), and what one more instant takes.
import { statSync } from "node:fs";
import { resolve } from "node:path";
import { pathToFileURL } from "node:url";
import { Browser } from "../tests/report/browser.mjs";

const [page, chromium = "chromium"] = process.argv.slice(2);
const instants = 40;
/** Milliseconds for an instant: to place points, rods and arrows and to write the numbers; and to draw them too. */
const measure = (draws) => `(() => {
  const { begin, end } = tanorPage, before = performance.now();
  for (let k = 0; k < ${instants}; ++k) { tanorPage.seek(begin + (end - begin) * k / ${instants}); ${draws ? "tanorPage.render();" : ""} }
  return (performance.now() - before) / ${instants};
})()`;
const median = (numbers) => numbers.toSorted((a, b) => a - b)[Math.floor(numbers.length / 2)];

const rounds = [];
for (let k = 0; k < 5; ++k) {
  const browser = new Browser(chromium);
  try {
    await browser.open(pathToFileURL(resolve(page)).href);
    rounds.push([await browser.ask("tanorPage.firstPicture"), await browser.ask(measure(false)), await browser.ask(measure(true))]);
  } finally {
    await browser.end();
  }
}
const [first, placed, drawn] = [0, 1, 2].map((k) => median(rounds.map((round) => round[k])));
console.log(`${(statSync(page).size / 1e6).toFixed(2)} MB; medians of ${rounds.length}: first picture after ${first.toFixed(0)} ms, ` +
  `an instant placed in ${placed.toFixed(1)} ms, placed and drawn without a GPU in ${drawn.toFixed(0)} ms`);
