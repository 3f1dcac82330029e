// The page in a real browser against the real daemon.
import assert from 'node:assert/strict';
import {mkdtempSync, readFileSync, rmSync, writeFileSync} from 'node:fs';
import {createRequire} from 'node:module';
import {tmpdir} from 'node:os';
import {dirname, join} from 'node:path';
import {after, before, test} from 'node:test';
import {fileURLToPath} from 'node:url';
import {
  CrclClient,
  Daemon,
  openBrowser,
  openPage,
  stopAll,
  until,
  writeRegister
} from './harness.mjs';
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
  await stopAll();
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

test('a state is saved and gone on from', async () => {
  const time = () => page.getByTestId('sim-time').textContent();
  await page.getByTestId('play').click();
  await until('a pause', async () => (await page.getByTestId('rtf').textContent()) === 'paused');
  const start = await time();
  await page.getByTestId('states').click();
  const dialog = page.getByRole('dialog', {name: 'Saved states'});
  await dialog.getByLabel('Name of the state').fill('from the page');
  await dialog.getByTestId('save-state').click();
  const load = dialog.getByRole('button', {name: 'Load from the page'});
  await load.waitFor();
  await dialog.getByRole('button', {name: 'Close'}).click();
  await page.getByRole('button', {name: '+100'}).click();
  await until('time to pass', async () => (await time()) !== start);
  await page.getByTestId('states').click();
  await load.click();
  await until('the time of the state', async () => (await time()) === start);
  await dialog.getByRole('button', {name: 'Close'}).click();
  await page.getByTestId('play').click();
  assert.deepEqual(page.complaints, []);
});

test('joints move on screen when a CRCL client moves the robot', async () => {
  const look = () => page.locator('.stage canvas').screenshot();
  await page.getByTestId('layer-trails').click();
  const before = await look();
  const client = await CrclClient.open(daemon.ports['crcl.fanuc']);
  await client.run('InitCanonType');
  await client.moveJoints([40, -20, 0, 0, -60, 0]);
  await until(
    'joint 1 in the panel',
    async () => Math.abs((await value('fanuc-joint-1')) - 40) < 0.05
  );
  const moved = await countColors(await look(), before);
  assert.ok(moved.changed > 1500, `changed pixels: ${moved.changed}`);
  client.close();
});

/** Presses a button and holds it. */
async function hold(id, of = page) {
  const button = of.getByTestId(id);
  await until('a ready robot', () => button.isEnabled());
  await button.hover();
  await of.mouse.down();
}

test('a jog moves the robot and ends when the button is released', async () => {
  await page.getByTestId('choose-motoman').click();
  await page.getByTestId('init-motoman').click();
  await until('a ready robot', () => page.getByTestId('jog motoman joint 1 plus').isEnabled());
  const start = await value('motoman-joint-1');
  await hold('jog motoman joint 1 plus');
  await until('motion', async () => (await value('motoman-joint-1')) > start + 2);
  await page.mouse.up();
  await atRest('motoman-joint-1');
  const end = await value('motoman-joint-1');
  assert.ok(end < 100, `stopped at ${end}`);
  assert.match(await page.getByTestId('robot-motoman').textContent(), /last commandstop/);
});

test('a jog ends when the window loses the focus, though the button is still held', async () => {
  const start = await value('motoman-joint-1');
  await hold('jog motoman joint 1 minus');
  await until('motion', async () => (await value('motoman-joint-1')) < start - 2);
  await page.evaluate(() => window.dispatchEvent(new Event('blur')));
  await atRest('motoman-joint-1');
  await page.mouse.up();
  assert.ok((await value('motoman-joint-1')) > -100);
});

const seconds = (text) => Number.parseFloat(text);

/** Simulated time that the page shows [s]. */
async function shownTime() {
  return seconds(await page.getByTestId('sim-time').textContent());
}

/** Waits until a value has been the same for half a second of simulated time. */
async function atRest(id) {
  let last = NaN,
    since = 0;
  await until(`${id} at rest`, async () => {
    const [now, time_s] = [await value(id), await shownTime()];
    if (now !== last) {
      last = now;
      since = time_s;
    }
    return time_s - since > 0.5;
  });
}

test('a tool jog moves along a straight line', async () => {
  const [x, z] = [await value('motoman-tcp-x'), await value('motoman-tcp-z')];
  await hold('jog motoman along -z');
  await until('motion', async () => (await value('motoman-tcp-z')) < z - 8);
  await page.mouse.up();
  await atRest('motoman-tcp-z');
  assert.ok(Math.abs((await value('motoman-tcp-x')) - x) < 0.2, 'x stays');
});

test('a jog ends when the connection drops', async () => {
  const start = await value('motoman-joint-2');
  await hold('jog motoman joint 2 plus');
  await until('motion', async () => (await value('motoman-joint-2')) > start + 1);
  await page.evaluate(() =>
    document.querySelector('main.stage').view.state.connection.socket.close()
  );
  await until(
    'a live page',
    async () => (await page.getByTestId('connection').textContent()) === 'live'
  );
  await atRest('motoman-joint-2');
  await page.mouse.up();
  assert.ok((await value('motoman-joint-2')) < 80);
});

test('pause freezes the time, a step is a millisecond, play goes on', async () => {
  const time = () => page.getByTestId('sim-time').textContent();
  await page.getByTestId('play').click();
  await until(
    'a paused cell',
    async () => (await page.getByTestId('play').textContent()) === 'Play'
  );
  const frozen = await time();
  await page.waitForFunction(() => new Promise((go) => setTimeout(() => go(true), 700)));
  assert.equal(await time(), frozen);
  for (let i = 0; i < 10; ++i) await page.getByTestId('step').click();
  await until('ten steps', async () => (await time()) !== frozen);
  await until(
    'exactly ten',
    async () => Math.abs(seconds(await time()) - seconds(frozen) - 0.01) < 0.0051
  );
  await page.getByTestId('play').click();
  await until('time to pass', async () => seconds(await time()) > seconds(frozen) + 0.3);
});

test('a Modbus write shows in the registers and in the traffic', async () => {
  await tab('Modbus');
  await writeRegister(daemon.ports.modbus, 0x8002, 15000);
  await until(
    'the request and its reply',
    async () => (await page.getByTestId('modbus-rows').locator('tr').count()) >= 2
  );
  assert.match(
    await page.getByTestId('modbus-rows').textContent(),
    /6 write register.*0x8002 := 15000/
  );
  await tab('Conveyor');
  const row = page.getByTestId('register-holding-speed');
  await until('the register', async () => /0\.15000 m\/s.*0x3A98/.test(await row.textContent()));
  await page.getByTestId('belt-forward').click();
  await until('the belt to run', async () =>
    /0x0001/.test(await page.getByTestId('register-holding-run').textContent())
  );
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
  assert.match(await row.textContent(), new RegExp(`→Dwellfanuc · ${id}Done`));
  await row.getByRole('button').click();
  assert.match(await page.locator('.xml').textContent(), /<DwellTime>0\.2<\/DwellTime>\n/);
  client.close();
});

test('an error shows with its reason, on the fault line too, and can be cleared', async () => {
  await page.getByTestId('choose-fanuc').click();
  const client = await CrclClient.open(daemon.ports['crcl.fanuc']);
  await client.run('InitCanonType');
  await assert.rejects(client.moveJoints([500, 0, 0, 0, 0, 0]));
  client.close();
  const robot = page.getByTestId('robot-fanuc');
  await until('the error', async () =>
    /joint_1|500/.test(await robot.getByTestId('robot-description').textContent())
  );
  await tab('Faults');
  await until('the fault', async () =>
    /fanuc/.test(await page.getByTestId('faults').textContent())
  );
  await tab('Robots');
  await page.getByTestId('init-fanuc').click();
  await until(
    'no error',
    async () => (await page.getByTestId('state-fanuc').textContent()) === 'done'
  );
});

test('what is drawn is where the daemon has it', async () => {
  const differences = await page.evaluate(() => {
    const {view} = document.querySelector('main.stage');
    const {cell, snapshot} = view.state;
    const V = view.camera.position.constructor,
      Q = view.camera.quaternion.constructor;
    const far = [];
    view.scene.updateMatrixWorld(true);
    // The drawn arm's flange, from its joints, and the tool's pose that the daemon tells.
    cell.robots.forEach((robot, i) => {
      const {x, y, z} = robot.toolInFlange.positionM;
      const drawn = new V(x, y, z).applyMatrix4(view.robots[i].arm.links.flange.matrixWorld),
        told = snapshot.robots[i].toolInWorld.positionM;
      far.push([robot.name, drawn.distanceTo(new V(told.x, told.y, told.z))]);
    });
    // Every gear that was put into a pocket of a tray: where the daemon's slot is.
    cell.bodies.forEach((tray, i) => {
      if (tray.geometry.case !== 'tray') return;
      const at = snapshot.bodies[i].bodyInWorld,
        q = new Q(at.orientation.x, at.orientation.y, at.orientation.z, at.orientation.w);
      for (const slot of tray.geometry.value.slots) {
        const p = slot.slotInTray.positionM;
        const pocket = new V(p.x, p.y, p.z)
          .applyQuaternion(q)
          .add(new V(at.positionM.x, at.positionM.y, at.positionM.z));
        const nearest = Math.min(
          ...cell.bodies.map((body, g) =>
            body.type === slot.gearType
              ? view.parts.meshes[g].position.distanceTo(pocket)
              : Infinity
          )
        );
        if (nearest < 0.01) far.push([`${tray.name} ${slot.name}`, nearest]);
      }
    });
    return far;
  });
  assert.ok(differences.length > 10, `compared: ${differences.length}`);
  for (const [name, far] of differences)
    assert.ok(far < 5e-4, `${name} is drawn ${1e3 * far} mm away`);
});

/** Clicks on a body where it is drawn. */
async function clickOn(body, of = page) {
  const [x, y] = await of.evaluate((name) => {
    const {view} = document.querySelector('main.stage');
    const p =
      view.parts.meshes[view.state.cell.bodies.findIndex((b) => b.name === name)].position.clone();
    p.z += 0.004;
    p.project(view.camera);
    const area = view.renderer.domElement.getBoundingClientRect();
    return [area.left + ((p.x + 1) / 2) * area.width, area.top + ((1 - p.y) / 2) * area.height];
  }, body);
  await of.mouse.click(x, y);
}

test('picking an object tells its name, pose, mass and contacts', async () => {
  await page.locator('body').press('h');
  const names = await page.evaluate(() =>
    document.querySelector('main.stage').view.state.cell.bodies.map((b) => b.name)
  );
  const gear = names.find((name) => /large_gear/.test(name));
  await clickOn(gear);
  const pick = page.getByTestId('pick');
  await until('its name', async () => (await pick.locator('h2').textContent()) === gear);
  const told = await pick.textContent();
  assert.match(told, /mass\d+\.\d g/);
  assert.match(told, /for fanuc-?\d+\.\d\d, -?\d+\.\d\d, -?\d+\.\d\d mm/);
  assert.match(told, /in the world-?\d+\.\d\d, -?\d+\.\d\d, \d+\.\d\d mm/);
  assert.match(told, /contacts(within its group|\w+)/);
});

test('simplified groups and contacts with their forces show', async () => {
  const look = (of) => of.locator('.stage canvas').screenshot();
  const before = await look(page);
  await page.getByTestId('layer-groups').click();
  await until(
    'coloured groups',
    async () => (await countColors(await look(page), before)).changed > 500
  );
  await page.getByTestId('layer-groups').click();
  // Where nothing is simplified every contact is computed.
  const scenes = join(dirname(fileURLToPath(import.meta.url)), '../../world/scenes');
  const scene = join(daemon.directory, 'plain.yaml');
  writeFileSync(
    scene,
    readFileSync(join(scenes, 'aprs.yaml'), 'utf8')
      .replaceAll('types/', `${scenes}/types/`)
      .replace('simplification: dormant', 'simplification: off')
  );
  const plain = await Daemon.start(['--scene', scene, '--speed', 'stepped']);
  const other = await openPage(browser, plain);
  await other.getByTestId('layer-contacts').click();
  for (let i = 0; i < 5; ++i) await other.getByRole('button', {name: '+100'}).click();
  const shown = await until('arrows', () =>
    other.evaluate(() => {
      const {view} = document.querySelector('main.stage');
      const {cell, snapshot} = view.state,
        {contacts} = snapshot;
      if (
        snapshot.step < 500n ||
        view.contacts.dots.count !== contacts.length ||
        contacts.length < 20
      )
        return null;
      const gear = contacts
        .map((c) => c.first.thing)
        .find(
          (side) => side.case === 'body' && /large_gear/.test(cell.bodies[side.value].name)
        ).value;
      return {name: cell.bodies[gear].name, mass: cell.bodies[gear].massKg};
    })
  );
  await clickOn(shown.name, other);
  const told = await until('its contacts', async () =>
    /\((\d+) points, (\d+\.\d+) N\)/.exec(await other.getByTestId('pick').textContent())
  );
  assert.ok(
    Number(told[2]) > 9.81 * shown.mass - 0.02, // and what a pocket's walls press
    `${told[2]} N on ${shown.mass} kg`
  );
  await other.context().close();
  await plain.stop();
});

test('clients of every listener are counted', async () => {
  const client = await CrclClient.open(daemon.ports['crcl.fanuc']);
  await page.getByTestId('clients').click();
  const row = (name) => page.getByTestId('listeners').locator('tr', {hasText: name}).textContent();
  await until(
    'the controller',
    async () => (await row('crcl.fanuc')) === `crcl.fanuc${daemon.ports['crcl.fanuc']}1`
  );
  await until('this page', async () => Number((await row('web')).slice(-1)) >= 1);
  assert.match(await row('grpc'), /0$/);
  client.close();
  await page.getByLabel('Clients').getByRole('button', {name: 'Close'}).click();
});

test('charts pause and give their numbers as CSV', async () => {
  await tab('Charts');
  await page.getByTestId('chart-choice').fill('fanuc J1 position');
  await page.getByTestId('chart-choice').press('Tab');
  await until('the chart', () => page.getByText('fanuc J1 position [°]').isVisible());
  const [download] = await Promise.all([
    page.waitForEvent('download'),
    page.getByRole('button', {name: 'CSV'}).click()
  ]);
  const lines = readFileSync(await download.path(), 'utf8')
    .trim()
    .split('\n');
  assert.match(lines[0], /^time \[s\],.*fanuc J1 position \[°\]$/);
  assert.ok(lines.length > 10, `${lines.length} lines`);
  assert.match(lines.at(-1), /^\d+\.\d{4},/);
  await tab('Robots');
});

test('no accessibility finding, dark or light; fits a phone', async () => {
  const other = await openPage(browser, daemon, {bypassCSP: true});
  await other.evaluate(axe);
  for (const theme of ['dark', 'light']) {
    assert.equal(await other.evaluate(() => document.documentElement.dataset.theme), theme);
    // Beside the view; panels.test.mjs has every panel in both colours without one.
    for (const name of ['Charts', 'Robots']) {
      await tab(name, other);
      const {violations} = await other.evaluate(() =>
        globalThis.axe.run(document, {resultTypes: ['violations']})
      );
      assert.deepEqual(
        violations.map(
          (v) =>
            `${theme} ${name}: ${v.id}: ${v.nodes
              .map((n) => n.html)
              .slice(0, 3)
              .join(' | ')}`
        ),
        []
      );
    }
    await other.locator('body').press('d');
  }
  await other.setViewportSize({width: 390, height: 780});
  await until('a narrow page', () =>
    other.evaluate(() => getComputedStyle(document.querySelector('.scene')).display === 'none')
  );
  const width = await other.evaluate(() => document.documentElement.scrollWidth);
  assert.ok(width <= 390, `the page is ${width} wide`);
  assert.deepEqual(other.complaints, []);
  await other.context().close();
});

test("registers of a scene's own server have the names of their signals", async () => {
  const scene = join(mkdtempSync(join(tmpdir(), 'aprsim-web-')), 'mapped.yaml');
  writeFileSync(
    scene,
    [
      'base: aprs',
      'modbus_servers:',
      '  - name: line',
      '    registers:',
      '      - {area: coil, address: 0x8000, signal: belt.run, access: write}',
      '      - {area: holding, address: 0x8002, signal: belt.speed_setting_m_s, scale: 0.001, access: write}',
      ''
    ].join('\n')
  );
  const other = await Daemon.start(['--scene', scene]);
  const shown = await openPage(browser, other, {webgl: false});
  await shown.getByRole('tab', {name: 'Modbus'}).click();
  await writeRegister(other.ports['modbus.line'], 0x8002, 150);
  await writeRegister(other.ports.modbus, 0x8002, 15000);
  const rows = shown.getByTestId('modbus-rows');
  await until('both servers', async () => (await rows.locator('tr').count()) >= 4);
  const text = await rows.textContent();
  assert.match(text, /belt\.speed_setting_m_s 0x8002 := 150 \(0\.15\)/);
  assert.match(text, /speed 0x8002 := 15000 \(0\.15000 m\/s\)/);
  await shown.context().close();
  await other.stop();
  rmSync(dirname(scene), {recursive: true});
});

test('shortcuts are listed and work', async () => {
  await page.locator('body').press('?');
  await until('the list', () => page.getByTestId('help').isVisible());
  assert.match(await page.getByTestId('help').textContent(), /pause or resume/);
  await page.keyboard.press('Escape');
  const groups = page.getByTestId('layer-groups');
  await page.evaluate(() => document.activeElement?.blur());
  await page.keyboard.press('g');
  assert.equal(await groups.getAttribute('aria-pressed'), 'true');
});

test('comes back by itself after the daemon was started anew', async () => {
  const {ports} = daemon;
  await daemon.stop();
  await until('a word of it', async () =>
    /reconnecting/.test(await page.getByTestId('connection').textContent())
  );
  assert.ok(await page.getByTestId('play').isDisabled());
  assert.match(await page.getByTestId('play').getAttribute('title'), /No connection/);
  daemon = await Daemon.start(
    [
      'crcl.ports.fanuc=0',
      'crcl.ports.motoman=0',
      'vision.ports.fanuc=0',
      'vision.ports.motoman=0',
      'modbus.port=0',
      'grpc.port=0'
    ].flatMap((port) => ['--set', port]),
    ports
  );
  await until(
    'a live page',
    async () => (await page.getByTestId('connection').textContent()) === 'live'
  );
  await until(
    'a small time',
    async () => seconds(await page.getByTestId('sim-time').textContent()) < 10
  );
});
