// Pictures of the scene's cameras on the page.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import {bin, CrclClient, Daemon, openPage, openPlainBrowser, stopAll, until} from './harness.mjs';

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
  const page = await openPage(browser, daemon);
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
  assert.match(
    await page.locator('.cameras').textContent(),
    /fanuc_table, 1280 × 720, \d+\.\d{3} s/
  );

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

/** Marks over a camera's picture: place, text, and the most colourful pixel near them. */
const marksOf = (page, name) =>
  page.getByTestId(`camera-${name}`).evaluate((img) => {
    const canvas = document.createElement('canvas');
    canvas.width = img.naturalWidth;
    canvas.height = img.naturalHeight;
    if (canvas.width === 0) return [];
    const context = canvas.getContext('2d', {willReadFrequently: true});
    context.drawImage(img, 0, 0);
    return [...img.parentElement.querySelectorAll('svg g')].map((group) => {
      const circle = group.querySelector('circle');
      const x = Number(circle.getAttribute('cx'));
      const y = Number(circle.getAttribute('cy'));
      const {data} = context.getImageData(Math.round(x) - 4, Math.round(y) - 4, 9, 9);
      let colour = 0;
      for (let i = 0; i < data.length; i += 4) {
        const [r, g, b] = data.slice(i, i + 3);
        colour = Math.max(colour, Math.max(r, g, b) - Math.min(r, g, b));
      }
      return {x, y, colour, text: group.querySelector('title').textContent};
    });
  });

test('marks show what the vision lines say, at its place', async () => {
  const daemon = await Daemon.start();
  const page = await openPage(browser, daemon);
  await page.getByRole('tab', {name: 'Cameras'}).click();
  for (const [name, robot] of [
    ['fanuc_table', 'fanuc'],
    ['motoman_belt', 'motoman']
  ]) {
    const marks = await until(`marks of ${name}`, async () => {
      const seen = (await marksOf(page, name)).filter(({text}) => text.startsWith(`${robot}: `));
      return seen.length > 4 && seen;
    });
    const gears = marks.filter(({text}) => text.includes('_gear_') && !text.includes('vessel'));
    assert.ok(gears.length > 2, JSON.stringify(marks));
    for (const {x, y, colour, text} of gears) {
      assert.ok(x > 0 && x < 1280 && y > 0 && y < 720, text);
      assert.ok(colour > 60, `${text} is not on a gear: ${colour} at ${x} ${y}`);
    }
    assert.match(marks[0].text, /^\w+: \w+ -?\d\.\d{3} -?\d\.\d{3} m, -?\d+°$/);
  }
  await page.getByTestId('camera-detections').uncheck();
  await until('no marks', async () => (await marksOf(page, 'fanuc_table')).length === 0);
  assert.deepEqual(page.complaints, []);
});

test('another scene that is loaded brings its own cameras', async () => {
  const daemon = await Daemon.start();
  const page = await openPage(browser, daemon);
  await page.getByRole('tab', {name: 'Cameras'}).click();
  await page.getByTestId('camera-motoman_belt').waitFor();
  const client = join(bin, 'aprsim');
  execFileSync(client, ['reset', '--scene', 'aprs_2025', '--ports-file', daemon.portsFile]);
  await page.getByTestId('camera-teach_table').waitFor();
  assert.equal(await page.locator('.camera').count(), 5);
  const seen = await until('a picture of the new scene', async () => {
    const picture = await look(page.getByTestId('camera-fanuc_table'));
    return picture.width === 1920 && picture;
  });
  assert.equal(seen.height, 1080);
});

test('a scene without cameras says so', async () => {
  const daemon = await Daemon.start(['--scene', 'empty_belt']);
  const page = await openPage(browser, daemon);
  await page.getByRole('tab', {name: 'Cameras'}).click();
  await page.getByText('The scene has no cameras').waitFor();
  assert.deepEqual(page.complaints, []);
});
