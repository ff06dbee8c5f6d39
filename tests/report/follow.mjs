// follow.mjs URL CHROMIUM: opens a page that `tanor view` serves while its run goes on, and sees it arrive at its end.
import { Browser, tryInBrowser } from "./browser.mjs";

const [url, chromium] = process.argv.slice(2);

async function tryFollowing(browser) {
  await browser.open(url);
  browser.expect(await browser.ask("tanorPage.run.is_running"), "the run is over before it was seen");
  browser.expect(await browser.ask(`!document.getElementById("running").hidden`), "nothing says that the run goes on");
  const seen = await browser.ask("tanorPage.end");
  browser.expect(await browser.wait(`tanorPage.end > ${seen}`, 60), "no newer state of the run is shown");
  browser.expect(await browser.wait("tanorPage.time === tanorPage.end", 10), "the view does not stay at the end");
  console.log("running"); // and whoever started the run may end it
  browser.expect(await browser.wait("!tanorPage.run.is_running", 60), "the end of the run is not shown");
  browser.expect((await browser.countPixels()).drawn > 200, "hardly a pixel is drawn");
  browser.expect(await browser.ask(`document.getElementById("running").hidden`), "the page still says that the run goes on");
}

await tryInBrowser(new Browser(chromium, { width: 960, height: 640, scale: 0.5, network: url }), tryFollowing);
