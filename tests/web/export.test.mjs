// A run that was recorded, for other programs: tables, an MCAP file read by MCAP's own library, and
// one page that shows the run without a daemon or a network. And the view as picture and film.
import assert from 'node:assert/strict';
import {execFile} from 'node:child_process';
import {mkdtempSync, readFileSync, rmSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {dirname, join} from 'node:path';
import {after, before, test} from 'node:test';
import {fileURLToPath, pathToFileURL} from 'node:url';
import {promisify} from 'node:util';
import {McapIndexedReader, McapStreamReader} from '@mcap/core';
import {decompress} from 'fzstd';
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

const here = dirname(fileURLToPath(import.meta.url));
const bin = process.env.APRSIM_BIN_DIR ?? join(here, '../../build/release/bin');
const run = promisify(execFile);

let browser, folder, journal, live;

/** Output of `aprsim trace export` for one run. */
async function exported(...options) {
  const {stdout} = await run(
    join(bin, 'aprsim'),
    ['trace', 'export', journal, '--json', ...options],
    {
      maxBuffer: 1 << 26
    }
  );
  return JSON.parse(stdout);
}

before(async () => {
  folder = mkdtempSync(join(tmpdir(), 'aprsim-export-'));
  journal = join(folder, 'run.journal');
  browser = await openBrowser();
  const daemon = await Daemon.start(['--journal', journal, '--speed', '4']);
  const robot = await CrclClient.open(daemon.ports['crcl.fanuc']);
  await robot.run('InitCanonType');
  await robot.moveJoints([25]);
  await writeRegister(daemon.ports.modbus, 0x8002, 12000);
  await writeRegister(daemon.ports.modbus, 0x8000, 1);
  await robot.moveJoints([-25]);
  await writeRegister(daemon.ports.modbus, 0x8000, 0);
  await robot.run('SetEndEffectorType', '<Setting>0</Setting>');
  robot.close();
  live = await pictures(daemon);
  await daemon.stop();
});
after(async () => {
  await browser?.close();
  await stopAll();
  if (folder) rmSync(folder, {recursive: true, force: true});
});

async function downloaded(page, button, act = () => button.click()) {
  const [file] = await Promise.all([page.waitForEvent('download'), act()]);
  return readFileSync(await file.path());
}

/** The live page's view as picture and film. */
async function pictures(daemon) {
  const page = await openPage(browser, daemon);
  const picture = await downloaded(page, page.getByTestId('picture'));
  const film = page.getByTestId('film');
  await film.click();
  assert.equal(await film.getAttribute('aria-pressed'), 'true');
  // Something that is filmed: the view turns.
  await page.keyboard.press('h');
  const begin = await page.evaluate(
    () => document.querySelector('main.stage').view.renderer.info.render.frame
  );
  await until('some pictures', async () => {
    await page.mouse.move(400, 400);
    await page.mouse.down();
    await page.mouse.move(400 + 40 * Math.random(), 400);
    await page.mouse.up();
    const now = await page.evaluate(
      () => document.querySelector('main.stage').view.renderer.info.render.frame
    );
    return now > begin + 5;
  });
  const webm = await downloaded(page, film);
  const {complaints} = page;
  await page.close();
  return {picture, webm, complaints};
}

test('the view is saved as a picture and as a film', async () => {
  assert.deepEqual(live.complaints, []);
  const colors = await countColors(live.picture);
  assert.ok(colors.yellow > 500, `the Fanuc is in the picture: ${JSON.stringify(colors)}`);
  // EBML, and the kind of document it holds.
  assert.equal(live.webm.subarray(0, 4).toString('hex'), '1a45dfa3');
  assert.ok(live.webm.subarray(0, 64).includes('webm'));
  assert.ok(live.webm.length > 5000, `${live.webm.length} bytes of film`);
});

/** Lines of a table without its head. */
function rows(name) {
  const lines = readFileSync(join(folder, 'tables', name), 'utf8')
    .trim()
    .split('\n');
  return {head: lines[0].split(','), lines: lines.slice(1)};
}

test('tables have every joint, body and thing of the wires', async () => {
  const told = await exported('--csv', join(folder, 'tables'), '--rate', '10');
  assert.equal(told.written, 'csv');
  assert.ok(told.snapshots > 20, JSON.stringify(told));
  const joints = rows('joints.csv');
  assert.deepEqual(joints.head.slice(0, 4), ['time_s', 'robot', 'joint', 'position_rad']);
  assert.equal(joints.lines.length, told.snapshots * (6 + 7));
  const first = joints.lines
    .filter((line) => /^[^,]*,fanuc,1,/.test(line))
    .map((l) => Number(l.split(',')[3]));
  assert.ok(
    Math.max(...first) > 0.43 && Math.min(...first) < -0.43,
    'joint 1 went from 25 to -25 degrees'
  );
  assert.equal(rows('belt.csv').lines.length, told.snapshots);
  assert.ok(Number(rows('belt.csv').lines.at(-1).split(',')[4]) > 0.01, 'the belt has moved');
  assert.equal(rows('bodies.csv').lines.length % told.snapshots, 0);
  assert.equal(rows('wires.csv').lines.length, told.wires);
  assert.ok(
    rows('wires.csv').lines.some((line) => /crcl.fanuc,\d+,in,"?\d+ ActuateJoints/.test(line))
  );
  assert.ok(rows('wires.csv').lines.some((line) => /modbus,\d+,in,write speed/.test(line)));
});

test('an MCAP file has as many messages as were written, by another library', async () => {
  const file = join(folder, 'run.mcap');
  const told = await exported('--mcap', file, '--rate', '10');
  const bytes = readFileSync(file);
  const decompressHandlers = {
    zstd: (packed, size) => decompress(packed, new Uint8Array(Number(size)))
  };
  const reader = await McapIndexedReader.Initialize({
    readable: {
      size: async () => BigInt(bytes.length),
      read: async (offset, length) =>
        new Uint8Array(bytes.subarray(Number(offset), Number(offset + length)))
    },
    decompressHandlers
  });
  const counts = {};
  let last = -1n;
  for await (const message of reader.readMessages()) {
    assert.ok(message.logTime >= last, 'in the order of time');
    last = message.logTime;
    const channel = reader.channelsById.get(message.channelId);
    counts[channel.topic] = (counts[channel.topic] ?? 0) + 1;
    const value = JSON.parse(Buffer.from(message.data).toString());
    const schema = JSON.parse(
      Buffer.from(reader.schemasById.get(channel.schemaId).data).toString()
    );
    for (const name of Object.keys(schema.properties))
      assert.ok(name in value, `${channel.topic} has ${name}`);
  }
  assert.deepEqual(counts, {
    '/tf': told.snapshots,
    '/scene': 1,
    '/joints': told.snapshots,
    '/belt': told.snapshots,
    '/wires': told.wires,
    ...(told.events > 0 && {'/events': told.events, '/log': told.events})
  });
  assert.equal(Number(reader.statistics.messageCount), told.messages);
  const schemas = [...reader.schemasById.values()].map(({name, encoding}) => `${name} ${encoding}`);
  for (const name of ['FrameTransforms', 'SceneUpdate', 'Log'])
    assert.ok(schemas.includes(`foxglove.${name} jsonschema`), schemas.join());
  // From beginning to end as well, without the index; with the checks of the format that this does.
  const stream = new McapStreamReader({decompressHandlers});
  stream.append(new Uint8Array(bytes));
  let messages = 0;
  for (let record; (record = stream.nextRecord()); ) if (record.type === 'Message') ++messages;
  assert.equal(messages, told.messages);
  assert.ok(stream.done());
});

test('one page shows the run without a network', async () => {
  const file = join(folder, 'run.html');
  const told = await exported('--html', file);
  assert.ok(told.snapshots > 40, JSON.stringify(told));
  const context = await browser.newContext({
    viewport: {width: 1200, height: 800},
    offline: true
  });
  const page = await context.newPage();
  page.setDefaultTimeout(90000);
  const complaints = [],
    asked = [];
  page.on('pageerror', (error) => complaints.push(String(error)));
  page.on('console', (message) => {
    if (message.type() === 'error' && !/GL Driver|WebGL|swiftshader/i.test(message.text()))
      complaints.push(message.text());
  });
  page.on('request', (request) => {
    if (!/^(file|data|blob):/.test(request.url())) asked.push(request.url());
  });
  await page.goto(pathToFileURL(file).href);
  await page.waitForSelector('main[data-frames=drawn]', {timeout: 300000});
  const before = await page.locator('main.stage').screenshot();
  const colors = await countColors(before);
  assert.ok(colors.yellow > 500, `the Fanuc is drawn: ${JSON.stringify(colors)}`);

  // Scrubbing: joint 1 goes there and back, somewhere in a run of whatever length.
  const slider = page.getByTestId('time');
  const end = Number(await slider.getAttribute('max'));
  const seen = await slider.evaluate((input) => {
    const {state} = document.querySelector('main.stage').view;
    const found = [];
    for (let time_s = Number(input.min); time_s < Number(input.max); time_s += 0.1) {
      input.value = String(time_s);
      input.dispatchEvent(new Event('input'));
      found.push(state.snapshot.robots[0].joints[0].positionRad);
    }
    return found;
  });
  assert.ok(
    Math.max(...seen) > 0.3 && Math.min(...seen) < -0.3,
    `${Math.min(...seen)} to ${Math.max(...seen)}`
  );
  const changed = await until('another picture', async () => {
    const {changed} = await countColors(await page.locator('main.stage').screenshot(), before);
    return changed > 300 && changed;
  });
  assert.ok(changed > 300);

  // It plays, to its end, from its beginning.
  await slider.evaluate((input) => {
    input.value = input.min;
    input.dispatchEvent(new Event('input'));
  });
  await page.getByLabel('Speed').selectOption('10');
  await page.getByTestId('play').click();
  await until('the end', async () => Number(await slider.inputValue()) >= end - 1e-6);
  assert.equal(await page.getByTestId('play').textContent(), 'Play');

  // Traffic of the wires, and a click that goes there.
  await page.getByRole('tab', {name: 'Wires'}).click();
  const line = page.locator('.wire-lines li', {hasText: 'ActuateJoints'}).first();
  const at = parseFloat(await line.getByRole('button').textContent());
  await line.getByRole('button').click();
  assert.ok(Math.abs(Number(await slider.inputValue()) - at) < 0.01);
  await page.getByRole('tab', {name: 'Charts'}).click();
  assert.ok((await page.locator('.strip canvas').count()) >= 2);
  const picture = await downloaded(page, page.getByTestId('picture'));
  assert.ok((await countColors(picture)).yellow > 300);
  assert.deepEqual(complaints, []);
  assert.deepEqual(asked, []);
  await context.close();
});
