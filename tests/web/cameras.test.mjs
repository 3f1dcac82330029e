// Pictures of the scene's cameras on the page.
import assert from 'node:assert/strict';
import {after, before, test} from 'node:test';
import {CrclClient, Daemon, openPage, openPlainBrowser, stopAll, until} from './harness.mjs';

let browser;
before(async () => {
  browser = await openPlainBrowser();
});
after(async () => {
  await browser?.close();
  await stopAll();
});

/** Size and darkest and brightest value of the picture that an element shows. */
const look = (picture) =>
  picture.evaluate((img) => {
    const canvas = document.createElement('canvas');
    canvas.width = img.naturalWidth;
    canvas.height = img.naturalHeight;
    const context = canvas.getContext('2d');
    context.drawImage(img, 0, 0);
    const {data} = context.getImageData(0, 0, canvas.width, canvas.height);
    let least = 255;
    let most = 0;
    let sum = 0;
    for (let i = 0; i < data.length; i += 4) {
      least = Math.min(least, data[i]);
      most = Math.max(most, data[i]);
      sum = (sum * 31 + data[i]) % 4294967291;
    }
    return {width: canvas.width, height: canvas.height, least, most, sum};
  });

test('each camera is live while its panel is open, and asked for nothing else', async () => {
  const daemon = await Daemon.start();
  const page = await openPage(browser, daemon, {frames: 'none'});
  let asked = 0;
  page.on('request', (request) => (asked += request.url().includes('/camera?') ? 1 : 0));
  assert.equal(asked, 0);
  await page.getByRole('tab', {name: 'Cameras'}).click();
  const first = {};
  for (const name of ['fanuc_table', 'motoman_belt']) {
    const picture = page.getByTestId(`camera-${name}`);
    first[name] = await until(`a picture of ${name}`, async () => {
      const seen = await look(picture);
      return seen.width > 0 && seen;
    });
    assert.equal(first[name].width, 1280);
    assert.equal(first[name].height, 720);
    assert.ok(first[name].least < 40 && first[name].most > 200, JSON.stringify(first[name]));
  }
  const client = await CrclClient.open(daemon.ports['crcl.fanuc']);
  await client.run('InitCanonType');
  await client.moveJoints([30, -10, 0, 0, -60, 0]);
  client.close();
  await until('the arm to move in the picture', async () => {
    return (await look(page.getByTestId('camera-fanuc_table'))).sum !== first.fanuc_table.sum;
  });
  assert.match(await page.locator('.cameras').textContent(), /fanuc_table, 1280 × 720, step \d+/);

  await page.getByRole('tab', {name: 'Robots'}).click();
  let before = -1;
  await until('an end of the requests', async () => {
    const same = asked === before;
    before = asked;
    await new Promise((go) => setTimeout(go, 500));
    return same && asked === before;
  });
  assert.ok(asked > 2, `${asked} requests`);
  assert.deepEqual(page.complaints, []);
});

test('a scene without cameras says so', async () => {
  const daemon = await Daemon.start(['--scene', 'empty_belt']);
  const page = await openPage(browser, daemon, {frames: 'none'});
  await page.getByRole('tab', {name: 'Cameras'}).click();
  await page.getByText('The scene has no cameras').waitFor();
  assert.deepEqual(page.complaints, []);
});
