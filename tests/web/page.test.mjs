// The page in a real browser against the real daemon.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import {after, before, test} from 'node:test';
import {CrclClient, Daemon, openBrowser, openPage, until, writeRegister} from './harness.mjs';
import {countColors} from './pixels.mjs';

const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
let daemon, browser, page;

before(async () => {
  daemon = await Daemon.start();
  browser = await openBrowser();
  page = await openPage(browser, daemon);
});
after(async () => {
  await browser?.close();
  await daemon?.stop();
});

const value = async (id, of = page) => Number.parseFloat(await of.getByTestId(id).textContent());
const tab = (name, of = page) => of.getByRole('tab', {name}).click();

test('the page shows the cell, in colours, without a complaint', async () => {
  const colors = await countColors(await page.locator('.stage canvas').screenshot());
  // Robot-coloured areas: the one's yellow, the other's blue, and white of both.
  assert.ok(colors.yellow > 300, `yellow pixels: ${colors.yellow}`);
  assert.ok(colors.blue > 300, `blue pixels: ${colors.blue}`);
  assert.ok(colors.different > 200, `different colours: ${colors.different}`);
  assert.deepEqual(page.complaints, []);
});

test('joints move on screen when a CRCL client moves the robot', async () => {
  const look = () => page.locator('.stage canvas').screenshot();
  await page.getByTestId('layer-trails').click();
  const before = await look();
  const client = await CrclClient.open(daemon.ports['crcl.fanuc']);
  await client.run('InitCanonType');
  await client.moveJoints(40, -20, 0, 0, -60, 0);
  await until('joint 1 in the panel', async () => Math.abs(await value('fanuc-joint-1') - 40) < 0.05);
  const moved = await countColors(await look(), before);
  assert.ok(moved.changed > 1500, `changed pixels: ${moved.changed}`);
  client.close();
});

test('a jog moves the robot and ends when the button is released', async () => {
  await page.getByTestId('init-motoman').click();
  const button = page.getByTestId('jog motoman joint 1 plus');
  await until('a ready robot', () => button.isEnabled());
  const start = await value('motoman-joint-1');
  await button.scrollIntoViewIfNeeded();
  const box = await button.boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await until('motion', async () => await value('motoman-joint-1') > start + 2);
  await page.mouse.up();
  await atRest('motoman-joint-1');
  const end = await value('motoman-joint-1');
  assert.ok(end < 100, `stopped at ${end}`);
});

async function atRest(id) {
  let last = NaN, since = Date.now();
  await until(`${id} at rest`, async () => {
    const now = await value(id);
    if (now !== last) {
      last = now;
      since = Date.now();
    }
    return Date.now() - since > 500;
  });
}

test('a tool jog moves along a straight line', async () => {
  const button = page.getByTestId('jog motoman along -z');
  await until('a ready robot', () => button.isEnabled());
  const [x, z] = [await value('motoman-tcp-x'), await value('motoman-tcp-z')];
  await button.scrollIntoViewIfNeeded();
  const box = await button.boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await until('motion', async () => await value('motoman-tcp-z') < z - 8);
  await page.mouse.up();
  await atRest('motoman-tcp-z');
  assert.ok(Math.abs(await value('motoman-tcp-x') - x) < 0.2, 'x stays');
});

test('a jog ends when the page goes away', async () => {
  const other = await openPage(browser, daemon);
  const button = other.getByTestId('jog motoman joint 2 plus');
  await until('a ready robot', () => button.isEnabled());
  await button.scrollIntoViewIfNeeded();
  const box = await button.boundingBox();
  const start = await value('motoman-joint-2');
  await other.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await other.mouse.down();
  await until('motion', async () => await value('motoman-joint-2') > start + 1);
  await other.context().close();
  await atRest('motoman-joint-2');
  assert.ok(await value('motoman-joint-2') < 80);
});

test('pause freezes the time, a step is a millisecond, play goes on', async () => {
  const time = () => page.getByTestId('sim-time').textContent();
  await page.getByTestId('play').click();
  await until('a paused cell', async () => await page.getByTestId('play').textContent() === 'Play');
  const frozen = await time();
  await page.waitForFunction(() => new Promise((go) => setTimeout(() => go(true), 700)));
  assert.equal(await time(), frozen);
  for (let i = 0; i < 10; ++i) await page.getByTestId('step').click();
  await until('ten steps', async () => await time() !== frozen);
  const seconds = (text) => 60 * Number(text.split(':')[0]) + Number(text.split(':')[1]);
  await until('exactly ten', async () => Math.abs(seconds(await time()) - seconds(frozen) - 0.01) < 0.0051);
  await page.getByTestId('play').click();
  await until('time to pass', async () => seconds(await time()) > seconds(frozen) + 0.3);
});

test('a Modbus write shows in the registers and in the traffic', async () => {
  await tab('Modbus');
  await writeRegister(daemon.ports.modbus, 0x8002, 15000);
  await until('the request and its reply', async () => await page.getByTestId('modbus-rows').locator('tr').count() >= 2);
  assert.match(await page.getByTestId('modbus-rows').textContent(), /6 write register.*0x8002 := 15000/);
  await tab('Conveyor');
  const row = page.getByTestId('register-holding-speed');
  await until('the register', async () => /0x3A98.*0\.15000 m\/s/.test(await row.textContent()));
  await page.getByTestId('belt-forward').click();
  await until('the belt to run', async () => /0x0001/.test(await page.getByTestId('register-holding-run').textContent()));
  await writeRegister(daemon.ports.modbus, 0x8000, 0);
});

test('CRCL documents show with type, id, state and latency', async () => {
  await tab('CRCL');
  const client = await CrclClient.open(daemon.ports['crcl.fanuc']);
  await client.run('InitCanonType');
  const id = client.id + 1;
  await client.run('DwellType', '<DwellTime>0.2</DwellTime>');
  const row = page.getByTestId('crcl-rows').locator('tr', {hasText: 'Dwell'}).first();
  await until('the command, done', async () => /Done\d+$/.test(await row.textContent()));
  assert.match(await row.textContent(), new RegExp(`→fanucDwell${id}Done`));
  await row.getByRole('button').click();
  assert.match(await page.locator('.xml').textContent(), /<DwellTime>0\.2<\/DwellTime>\n/);
  client.close();
});

test('an error shows with its reason, on the fault line too, and can be cleared', async () => {
  await tab('Robots');
  const client = await CrclClient.open(daemon.ports['crcl.fanuc']);
  await client.run('InitCanonType');
  await assert.rejects(client.moveJoints(500, 0, 0, 0, 0, 0));
  client.close();
  const robot = page.getByTestId('robot-fanuc');
  await until('the error', async () => /joint_1|500/.test(await robot.getByTestId('robot-description').textContent()));
  await tab('Faults');
  await until('the fault', async () => /fanuc/.test(await page.getByTestId('faults').textContent()));
  await tab('Robots');
  await page.getByTestId('init-fanuc').click();
  await until('no error', async () => await robot.getByTestId('robot-state').textContent() === 'done');
});

test('picking an object names it', async () => {
  await page.keyboard.press('h');
  const area = await page.locator('.stage canvas').boundingBox();
  await page.mouse.click(area.x + 0.5 * area.width, area.y + 0.62 * area.height);
  await until('a name', async () => (await page.getByTestId('pick').locator('h2').textContent()) !== '');
});

for (const theme of ['dark', 'light']) {
  test(`no serious accessibility finding (${theme})`, async () => {
    const other = await openPage(browser, daemon, {colorScheme: theme, bypassCSP: true});
    for (const name of ['Conveyor', 'CRCL', 'Modbus', 'Charts', 'Faults', 'Robots']) {
      await tab(name, other);
      await other.evaluate(axe);
      const {violations} = await other.evaluate(() => globalThis.axe.run(document, {resultTypes: ['violations']}));
      const serious = violations.filter((v) => ['serious', 'critical'].includes(v.impact));
      assert.deepEqual(serious.map((v) => `${name}: ${v.id}: ${v.nodes.map((n) => n.html).slice(0, 3).join(' | ')}`), []);
    }
    await other.context().close();
  });
}

test('fits a phone', async () => {
  const phone = await openPage(browser, daemon, {viewport: {width: 390, height: 780}, hasTouch: true, isMobile: true});
  const width = await phone.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(width <= 390, `the page is ${width} wide`);
  assert.deepEqual(phone.complaints, []);
  await phone.context().close();
});

test('shortcuts are listed and work', async () => {
  await page.locator('body').press('?');
  await until('the list', () => page.getByTestId('help').isVisible());
  assert.match(await page.getByTestId('help').textContent(), /pause or go on/);
  await page.keyboard.press('Escape');
  const groups = page.getByTestId('layer-groups');
  await page.evaluate(() => document.activeElement?.blur());
  await page.keyboard.press('g');
  assert.equal(await groups.getAttribute('aria-pressed'), 'true');
});

test('comes back by itself after the daemon was started anew', async () => {
  const {ports} = daemon;
  await daemon.stop();
  await until('a word of it', async () => /reconnecting/.test(await page.getByTestId('connection').textContent()));
  assert.ok(await page.getByTestId('play').isDisabled());
  assert.match(await page.getByTestId('play').getAttribute('title'), /No connection/);
  daemon = await Daemon.start(['--any-port'].slice(1).concat(['--set', 'crcl.ports.fanuc=0', '--set', 'crcl.ports.motoman=0', '--set', 'vision.ports.fanuc=0', '--set', 'vision.ports.motoman=0', '--set', 'modbus.port=0', '--set', 'grpc.port=0']), ports);
  await until('a live page', async () => await page.getByTestId('connection').textContent() === 'live');
  await until('a small time', async () => (await page.getByTestId('sim-time').textContent()).startsWith('0:0'));
});
