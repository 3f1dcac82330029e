// How long from opening the page to its first picture, robots and all, on the screen; the browser
// renders in software. usage: node tests/web/first_frame.mjs [TIMES]
import {Daemon, openBrowser, openPage} from './harness.mjs';

const times = Number(process.argv[2] ?? 7);
const daemon = await Daemon.start();
const browser = await openBrowser();
try {
  const took = [];
  for (let i = 0; i < times; ++i) {
    const page = await openPage(browser, daemon); // of a fresh profile: nothing cached
    took.push(await page.evaluate(() => performance.getEntriesByName('first-frame')[0].startTime));
    await page.context().close();
  }
  took.sort((a, b) => a - b);
  const seconds = (ms) => (ms / 1000).toFixed(2);
  console.log(
    `page to first frame [s]: median ${seconds(took[took.length >> 1])}, shortest ${seconds(took[0])}, longest ${seconds(took[took.length - 1])}, of ${times}`
  );
} finally {
  await browser.close();
  await daemon.stop();
}
