// Makes the README's picture of the page: the default cell at work.
// usage: node tests/web/screenshot.mjs [FILE.png] [WIDTHxHEIGHT] [dark|light]
import {spawn} from 'node:child_process';
import {dirname, join} from 'node:path';
import {fileURLToPath} from 'node:url';
import {Daemon, openBrowser, openPage, until} from './harness.mjs';

const here = dirname(fileURLToPath(import.meta.url));
const [file = join(here, '../../docs/pictures/page.png'), size = '1280x800', colorScheme = 'dark'] =
  process.argv.slice(2);
const [width, height] = size.split('x').map(Number);
const bin = process.env.APRSIM_BIN_DIR ?? join(here, '../../build/release/bin');

const daemon = await Daemon.start();
const browser = await openBrowser();
let page = await openPage(browser, daemon, {viewport: {width, height}, colorScheme});
const demo = spawn(
  join(bin, 'aprsim'),
  ['--ports-file', join(daemon.directory, 'ports.json'), 'demo'],
  {stdio: 'ignore'}
);
try {
  const robot = page.getByTestId('robot-fanuc');
  await until(
    'a gear in the gripper',
    async () => /part_/.test(await robot.locator('.facts').nth(1).textContent()),
    90000
  );
  const z = async () => Number.parseFloat(await page.getByTestId('fanuc-tcp-z').textContent());
  const low = await z();
  await until('the gear to be lifted', async () => (await z()) > low + 60, 60000);
  await page.getByTestId('play').click();
  await until(
    'a paused cell',
    async () => (await page.getByTestId('play').textContent()) === 'Play'
  );
  // Once more, finely, now that nothing moves; reflections and shadows come after the first picture.
  await page.context().close();
  page = await openPage(browser, daemon, {
    query: '?quality=fine',
    viewport: {width, height},
    colorScheme
  });
  await until(
    'the paused cell',
    async () => (await page.getByTestId('play').textContent()) === 'Play'
  );
  await page.waitForFunction(() => {
    const {view} = document.querySelector('main.stage');
    return view.scene.environment !== null && !view.dirty;
  });
  await page.screenshot({path: file});
} finally {
  demo.kill();
  await browser.close();
  await daemon.stop();
}
