// Records of the page and of the daemon: charts, faults, commands. Also keys, with any focus.
import assert from 'node:assert/strict';
import {readFileSync} from 'node:fs';
import {connect} from 'node:net';
import {after, before, test} from 'node:test';
import {
  CrclClient,
  Daemon,
  openPlainBrowser,
  openPage,
  stopAll,
  until,
  writeRegister
} from './harness.mjs';

let daemon, browser, page;

before(async () => {
  daemon = await Daemon.start();
  browser = await openPlainBrowser();
  page = await openPage(browser, daemon);
});
after(async () => {
  await browser?.close();
  await stopAll();
});

const tab = (name, of = page) => of.getByRole('tab', {name}).click();
const selected = (of = page) => of.getByRole('tab', {selected: true}).textContent();
const label = () => page.getByTestId('play').textContent();
const time = async (of = page) => {
  return Math.round(1000 * Number.parseFloat(await of.getByTestId('sim-time').textContent()));
};
async function saved(button, of = page) {
  const [file] = await Promise.all([
    of.waitForEvent('download'),
    of.getByRole('button', {name: button}).click()
  ]);
  return readFileSync(await file.path(), 'utf8');
}

test('a chart that is added shows the past at once', async () => {
  await tab('Charts');
  const start = await time();
  await until('three seconds of past', async () => (await time()) > start + 3000);
  await page.getByRole('button', {name: 'Pause'}).last().click(); // nothing comes any more
  await page.getByTestId('chart-choice').fill('fanuc J2 position');
  await page.getByTestId('chart-choice').press('Enter');
  const strip = page.locator('.strip').last();
  assert.match(await strip.textContent(), /^fanuc J2 position \[°\]/);
  // A line from left to right, of its colour.
  const drawn = await until('a line', () =>
    strip.locator('canvas').evaluate((canvas) => {
      const {data, width} = canvas.getContext('2d').getImageData(0, 0, canvas.width, canvas.height);
      const columns = new Set();
      for (let i = 0; i < data.length; i += 4)
        if (data[i + 3] > 100 && data[i] > 200 && data[i + 1] < 150) columns.add((i / 4) % width);
      return columns.size > 0 && columns.size / width;
    })
  );
  assert.ok(drawn > 0.7, `${drawn} of the width`);
  const lines = (await saved('CSV')).trim().split('\n');
  assert.match(lines[0], /fanuc J2 position/);
  assert.ok(lines.length > 30, `${lines.length} lines`);
  for (const line of lines) assert.doesNotMatch(line, /,(?=,|$)/, 'no value is missing');
});

test('the value under the cursor shows, and the latest without one', async () => {
  const strip = page.locator('.strip').last();
  const reading = strip.locator('output');
  assert.match(await reading.textContent(), /^-?\d+\.\d+ °$/);
  await strip.locator('.u-over').hover();
  await until('its value', async () =>
    /^\d+\.\d{3} s: -?\d+\.\d+ °$/.test(await reading.textContent())
  );
  // At the same time in every chart.
  const at = (await reading.textContent()).split(':')[0];
  assert.equal((await page.locator('.strip output').first().textContent()).split(':')[0], at);
  await page.mouse.move(5, 300);
  await page.getByRole('button', {name: 'Follow'}).click();
});

test('a mistyped signal is refused, with those that were meant', async () => {
  const choice = page.getByTestId('chart-choice');
  await choice.fill('fanuk tol z');
  await choice.press('Enter');
  const complaint = page.getByTestId('chart-complaint');
  assert.match(
    await complaint.textContent(),
    /There is no signal “fanuk tol z”\. Did you mean fanuc tool z/
  );
  assert.equal(await choice.inputValue(), 'fanuk tol z');
  await page.getByRole('button', {name: 'Remove fanuc tool z'}).click();
  await complaint.getByRole('button', {name: 'fanuc tool z', exact: true}).click();
  await page.getByRole('button', {name: 'Remove fanuc tool z'}).waitFor();
  assert.equal(await complaint.textContent(), '');
  await choice.fill('#+*');
  await choice.press('Enter');
  assert.match(await complaint.textContent(), /There is no signal “#\+\*”\. Try/);
});

test('Space and Enter press the focused button; Space pauses where nothing takes it', async () => {
  const paused = async () => (await label()) === 'Play';
  await tab('Robots');
  for (const key of ['Space', 'Enter']) {
    await page.getByTestId('reset').focus();
    await page.keyboard.press(key);
    const dialog = page.getByRole('dialog', {name: 'Reset the cell'});
    await dialog.waitFor();
    await dialog.getByRole('button', {name: 'Cancel'}).focus();
    await page.keyboard.press(key);
    await dialog.waitFor({state: 'detached'});
    assert.equal(await paused(), false, `${key} does not pause as well`);
  }
  await page.getByTestId('choose-motoman').focus();
  await page.keyboard.press('Space');
  assert.equal(await page.getByTestId('choose-motoman').getAttribute('aria-pressed'), 'true');
  await tab('CRCL');
  const quiet = page.getByTestId('crcl-quiet');
  await quiet.focus();
  await page.keyboard.press('Space');
  assert.ok(!(await quiet.isChecked()), 'a check box changes');
  await page.keyboard.press('Space');
  await page.getByLabel('Filter').first().fill('a');
  await page.getByLabel('Filter').first().press('Space');
  assert.equal(await page.getByLabel('Filter').first().inputValue(), 'a ');
  await page.getByLabel('Filter').first().fill('');
  assert.equal(await paused(), false);
  await page.evaluate(() => document.activeElement?.blur());
  await page.keyboard.press('Space');
  await until('a pause', paused);
  await page.keyboard.press('Space');
  await until('time to run again', async () => !(await paused()));
});

test('Escape closes what is open before it stops anything', async () => {
  const stops = () =>
    page.evaluate(() => {
      const {connection} = document.querySelector('main.stage').view.state;
      if (connection.request.stops === undefined) {
        const request = connection.request.bind(connection);
        connection.request = (body, patience_ms) => {
          if (body.case === 'stopCell') ++connection.request.stops;
          return request(body, patience_ms);
        };
        connection.request.stops = 0;
      }
      return connection.request.stops;
    });
  await stops();
  await page.evaluate(() => {
    const {view} = document.querySelector('main.stage');
    view.select({kind: 'belt'});
    view.onPick({kind: 'belt'});
    document.activeElement?.blur();
  });
  await page.getByTestId('pick').waitFor();
  await page.keyboard.press('?');
  await page.getByTestId('help').waitFor();
  await page.keyboard.press('Escape');
  await page.getByTestId('help').waitFor({state: 'detached'});
  assert.ok(await page.getByTestId('pick').isVisible(), 'one at a time');
  await page.keyboard.press('Escape');
  assert.ok(await page.getByTestId('pick').isHidden());
  if (await page.getByTestId('start').isVisible()) {
    await page.keyboard.press('Escape');
    assert.ok(await page.getByTestId('start').isHidden());
  }
  assert.equal(await stops(), 0, 'nothing was stopped so far');
  await page.keyboard.press('Escape');
  await until('the stop', async () => (await stops()) === 1);
});

test('keys that browsers need are left to them', async () => {
  await tab('Robots');
  await page.evaluate(() => document.activeElement?.blur());
  for (const key of ['Control+3', 'Alt+3', 'Meta+3']) await page.keyboard.press(key);
  assert.equal(await selected(), 'Robots');
  await page.keyboard.press('3');
  assert.equal(await selected(), 'CRCL');
});

test('a held key steps on, and the clock shows each millisecond', async () => {
  await page.getByTestId('play').click();
  await until('a paused cell', async () => (await label()) === 'Play');
  assert.match(await page.getByTestId('sim-time').textContent(), /^\d+\.\d{3} s$/);
  const start = await time();
  await page.evaluate(() => document.activeElement?.blur());
  await page.keyboard.down('.');
  await until('one step', async () => (await time()) === start + 1);
  for (let i = 2; i <= 12; ++i) {
    await page.keyboard.down('.'); // as a keyboard repeats it
    await until(`${i} steps`, async () => {
      if ((await time()) >= start + i) return true;
      await page.keyboard.down('.');
      return false;
    });
  }
  await page.keyboard.up('.');
  assert.equal(await page.locator('.toast.error').count(), 0);
  await page.getByTestId('play').click();
});

const polls = 3000; // as many as a controller makes in a minute
let later, id;

test('a page opened later learns what went wrong before', async () => {
  const badge = page.getByTestId('fault-count');
  assert.ok(await badge.isHidden(), 'nothing serious so far');
  const client = await CrclClient.open(daemon.ports['crcl.fanuc']);
  for (const angle of [500, 600]) {
    await client.run('InitCanonType');
    await assert.rejects(client.moveJoints([angle, 0, 0, 0, 0, 0]));
  }
  await until('one cause', async () => (await badge.textContent()) === '1');
  assert.equal(await badge.getAttribute('data-kind'), 'error');
  await tab('Conveyor');
  await page.getByRole('button', {name: 'Emergency stop', exact: true}).click();
  await until('a stop', async () => (await badge.getAttribute('data-kind')) === 'stop');
  // A saved state is no reset.
  await page.getByTestId('states').click();
  const dialog = page.getByRole('dialog', {name: 'Saved states'});
  await dialog.getByLabel('Name of the state').fill('before');
  await dialog.getByTestId('save-state').click();
  await dialog.getByRole('button', {name: 'Load before'}).click();
  await dialog.getByRole('button', {name: 'Close'}).click();
  // For the next test: a command, and many polls after it.
  await client.run('InitCanonType');
  id = client.id + 1;
  await client.run('MessageType', '<Message>kept in mind</Message>');
  client.received = '';
  for (let i = 0; i < polls; ++i) client.send('GetStatusType');
  await until('all statuses', () => client.received.split('</CRCLStatus>').length - 1 === polls);
  client.close();
  await writeRegister(daemon.ports.modbus, 0x8002, 12345);

  later = await openPage(browser, daemon);
  await tab('Faults', later);
  const list = later.getByTestId('faults');
  await until('the load', async () =>
    /continued from the saved state 'before'/.test(await list.textContent())
  );
  const lines = await list.locator('li').allTextContents();
  assert.match(lines[0], /^beltstop, lasts/, 'what has stopped stands first');
  const error = lines.find((line) => /^fanucerror/.test(line));
  assert.match(error, /[23]×/);
  assert.match(error, /last \d+\.\d{3} s.*, .*; first \d+\.\d{3} s/);
  assert.ok(!lines.some((line) => /^cellnotereset/.test(line)), lines.join('\n'));
  assert.equal(await later.getByTestId('fault-count').textContent(), '2');
  await page.getByRole('button', {name: 'Release emergency stop'}).click();
  await page.getByRole('button', {name: 'Reset fault'}).click();
  await until('no stop that lasts', async () => !/lasts/.test(await list.textContent()));
});

test('commands are kept from before the page was opened, polls apart', async () => {
  await tab('CRCL', later);
  const row = later.getByTestId('crcl-rows').locator('tr', {hasText: 'Message'}).first();
  assert.match(
    await row.textContent(),
    new RegExp(
      String.raw`^\d\d:\d\d:\d\d\.\d{3}\d+\.\d{3} s→Messagefanuc · ${id}Done: kept in mind\d+$`
    )
  );
  await row.getByRole('button').click();
  assert.match(await later.locator('.xml').textContent(), /kept in mind/);
  // Commands of this page join them.
  await later.getByTestId('stop-cell').click();
  const own = later.getByTestId('crcl-rows').locator('tr', {hasText: 'stop_cell'});
  await until('the page’s own command', async () =>
    /→stop_cellpage · \d+accepted/.test(await own.first().textContent())
  );
  const events = (await saved('Save as JSON', later))
    .trim()
    .split('\n')
    .map((line) => JSON.parse(line));
  assert.deepEqual(
    events.filter(({type}) => type === 'GetStatusType'),
    []
  );
  const message = events.find(({type}) => type === 'MessageType');
  assert.equal(message.id, id);
  assert.equal(message.source, 'crcl.fanuc');
  assert.equal(message.state, 'Done: kept in mind');
  assert.match(message.wall_time, /^20\d\d-.*Z$/);
  assert.ok(message.sim_time_s > 0);
  assert.match(message.data, /<Message>kept in mind<\/Message>/);
  assert.ok(events.some(({source, type}) => source === 'page' && type === 'stop_cell'));
  assert.match(
    await saved('Save as text', later),
    /s of run 1 {2}crcl\.fanuc from 127\.0\.0\.1:\d+ {2}Message/
  );
  // Polls come when they are asked for.
  await later.getByTestId('crcl-quiet').click();
  const other = await CrclClient.open(daemon.ports['crcl.fanuc']);
  await until('a poll', async () => {
    await other.status();
    return /GetStatus/.test(await later.getByTestId('crcl-rows').textContent());
  });
  other.close();
  await tab('Modbus', later);
  await until('register and value', async () =>
    /6 write register127\.0\.0\.1:\d+ · \d+speed 0x8002 := 12345 \(0\.12345 m\/s\)/.test(
      await later.getByTestId('modbus-rows').textContent()
    )
  );
  assert.match(await later.getByTestId('modbus-rows').textContent(), /speed 0x8002 = 12345/);
  await later.context().close();
});

test('a Modbus read shows names and values in its row', async () => {
  await tab('Modbus');
  const socket = connect(daemon.ports.modbus, '127.0.0.1');
  await until('register values', async () => {
    socket.write(Buffer.from([0, 5, 0, 0, 0, 6, 1, 3, 0x80, 0, 0, 3]));
    return /run 0x8000 = 0, direction 0x8001 = 1, speed 0x8002 = \d+ \(0\.\d+ m\/s\)/.test(
      await page.getByTestId('modbus-rows').textContent()
    );
  });
  socket.destroy();
});

test('registers are written from their table; refused values show the reason', async () => {
  await tab('Conveyor');
  const row = page.getByTestId('register-holding-speed');
  await row.getByRole('textbox').fill('0x2710');
  await row.getByRole('button', {name: 'Write speed'}).click();
  await until('the register', async () => /0\.10000 m\/s.*0x2710/.test(await row.textContent()));
  await row.getByRole('textbox').fill('40000');
  await row.getByRole('textbox').press('Enter');
  await until('the reason', async () =>
    /40000 is not in 0\.\.32768/.test(await row.getByRole('alert').textContent())
  );
  await row.getByRole('textbox').fill('fast');
  await row.getByRole('textbox').press('Enter');
  assert.match(await row.getByRole('alert').textContent(), /“fast” is not a whole number/);
  const coil = page.getByTestId('register-coil-run');
  await coil.getByRole('button', {name: 'run on'}).click();
  await until('the belt to run', async () =>
    /^on/.test(await coil.locator('td').nth(2).textContent())
  );
});

test('one press stops both robots and the belt, also on a phone', async () => {
  await page.setViewportSize({width: 390, height: 780});
  const clients = [];
  for (const name of ['fanuc', 'motoman']) {
    const client = await CrclClient.open(daemon.ports[`crcl.${name}`]);
    clients.push(client);
    await client.run('InitCanonType');
    client.send(
      'ActuateJointsType',
      '<ActuateJoint><JointNumber>1</JointNumber><JointPosition>60</JointPosition><JointDetails xsi:type="JointSpeedAccelType"><JointSpeed>3</JointSpeed></JointDetails></ActuateJoint>'
    );
  }
  await writeRegister(daemon.ports.modbus, 0x8000, 1);
  const state = () =>
    page.evaluate(() => {
      const {robots, conveyor} = document.querySelector('main.stage').view.state.snapshot;
      return [...robots.map((robot) => robot.moving), conveyor.run];
    });
  await until('motion', async () => (await state()).every(Boolean));
  await page.evaluate(() => scrollTo(0, document.body.scrollHeight));
  const box = await page.getByTestId('stop-cell').boundingBox();
  assert.ok(
    box.y >= 0 && box.y + box.height <= 780 && box.x + box.width <= 390,
    JSON.stringify(box)
  );
  await page.getByTestId('stop-cell').click();
  await until('a standing cell', async () => !(await state()).some(Boolean));
  clients.forEach((client) => client.close());
  await page.setViewportSize({width: 1200, height: 800});
});

/** A viewer that is no browser. */
async function view(server) {
  const socket = connect(server.ports.web, '127.0.0.1');
  const answer = new Promise((go) => socket.once('data', go));
  socket.write(
    `GET /ws HTTP/1.1\r\nHost: 127.0.0.1:${server.ports.web}\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n`
  );
  assert.match(String(await answer), /^HTTP\/1.1 101/);
  socket.resume();
  return socket;
}

test('a page that finds no room says so, and comes in when there is', async () => {
  const small = await Daemon.start(['--set', 'web.max_viewers=1']);
  const first = await view(small);
  const second = await (await browser.newContext()).newPage();
  await second.goto(small.url);
  const note = second.getByTestId('offline');
  await until('the reason', async () => /maximum number of viewers/.test(await note.textContent()));
  assert.doesNotMatch(await note.textContent(), /is old/);
  first.destroy();
  await until(
    'a live page',
    async () => (await second.getByTestId('connection').textContent()) === 'live'
  );
  await second.context().close();
  await small.stop();
});

test('a browser that finds no connection free is told so', async () => {
  const small = await Daemon.start([
    '--set',
    'web.max_connections=2',
    '--set',
    'web.max_viewers=2'
  ]);
  const sockets = [await view(small), await view(small)];
  const late = await (await browser.newContext()).newPage();
  const answer = await late.goto(small.url);
  assert.equal(answer.status(), 503);
  assert.match(await late.textContent('p'), /All 2 connections for browsers are in use/);
  sockets.forEach((socket) => socket.destroy());
  await late.context().close();
  await small.stop();
});
