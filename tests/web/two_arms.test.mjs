// A cell of two arms, a belt and two Modbus servers, made in the page from nothing: saved, checked,
// applied to a running cell of other robots, and run over the sockets that this opens.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {mkdtempSync, readFileSync, rmSync} from 'node:fs';
import {connect} from 'node:net';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import {
  bin,
  CrclClient,
  Daemon,
  openBrowser,
  openPage,
  stopAll,
  until,
  writeRegister
} from './harness.mjs';

const kServers = `
modbus_servers:
  - name: drive
    registers:
      - {area: holding, address: 0, signal: belt.speed_setting_m_s, scale: 0.001, access: write}
      - {area: holding, address: 1, signal: belt.run, access: write}
      - {area: holding, address: 2, signal: belt.forward, access: write}
  - name: meter
    registers:
      - {area: input, address: 0, signal: belt.travel_m, encoding: int32, scale: 0.0001}
`;

let daemon, browser, page, folder, old;

before(async () => {
  folder = mkdtempSync(join(tmpdir(), 'aprsim-two-arms-'));
  daemon = await Daemon.start(['--scene', 'aprs', '--set', 'modbus.full_scale_m_s=0.3']);
  old = await CrclClient.open(daemon.ports['crcl.fanuc']);
  browser = await openBrowser();
  page = await openPage(browser, daemon, {viewport: {width: 1440, height: 900}});
  await page.getByRole('tab', {name: 'Scene', exact: true}).click();
});
after(async () => {
  old?.close();
  await browser?.close();
  await stopAll();
  rmSync(folder, {recursive: true, force: true});
});

const id = (name) => page.getByTestId(name);
const idle = () =>
  until('the editor to be idle', () =>
    page.evaluate(() => document.getElementById('panel-Scene').ariaBusy === 'false')
  );
const text = () => id('editor-text').inputValue();

async function click(name) {
  await idle();
  await id(name).click();
  await idle();
  assert.equal(await id('editor-problem').textContent(), '', name);
}
async function add(label) {
  await idle();
  await id('editor-offer').selectOption({label});
  await click('editor-add');
}
async function setProperty(name, value) {
  await idle();
  await id(`property-${name}`).fill(String(value));
  await id(`property-${name}`).press('Enter');
  await idle();
  assert.equal(await id('editor-problem').textContent(), '', `${name} ${value}`);
}
const inPage = (work) =>
  page.evaluate(`(${work})(document.querySelector('main.stage').view, document)`);

/** Two input registers of a Modbus server, from the first one. */
function readTwo(port) {
  const socket = connect(port, '127.0.0.1');
  return new Promise((done, failed) => {
    socket.once('error', failed).once('data', (data) => {
      socket.destroy();
      done(data.readInt32BE(9));
    });
    socket.write(Buffer.from([0, 1, 0, 0, 0, 6, 1, 4, 0, 0, 0, 2]));
  });
}

test('a cell from nothing: a belt, a tray, two arms and two Modbus servers', async () => {
  await click('editor-begin');
  await page.getByText('Text and files').click();
  await click('editor-empty');
  await add('Belt');
  await add('sku_small_gear_vessel');
  assert.match(await text(), /on: conveyor/);
  for (const [arm, y] of [
    ['ur5e', -0.9],
    ['irb120', 0.9]
  ]) {
    await add(arm);
    await setProperty('base-xyz_m-1', y);
    await setProperty('base-xyz_m-0', 0);
  }
  await id('editor-text').fill((await text()) + kServers);
  await click('editor-use-text');
  await until('both arms in the view', () =>
    inPage((view) => view.robots.length === 2 && view.robots.every(({arm}) => arm !== null))
  );
});

test('the saved file passes the check of scenes', async () => {
  const [download] = await Promise.all([page.waitForEvent('download'), id('editor-save').click()]);
  const file = join(folder, download.suggestedFilename());
  await download.saveAs(file);
  assert.equal(readFileSync(file, 'utf8'), await text());
  execFileSync(join(bin, 'aprsim'), ['scene', 'check', file]);
});

test('the running cell takes it, and its sockets follow', async () => {
  const closed = new Promise((end) => old.socket.once('end', () => end('closed')));
  old.socket.once('error', (problem) => assert.fail(problem));
  await click('editor-apply');
  assert.equal(await closed, 'closed');
  await until('the ports of the new robots', () => {
    daemon.ports = JSON.parse(readFileSync(daemon.portsFile, 'utf8'));
    return daemon.ports['crcl.irb120_1'] && daemon.ports['modbus.meter'];
  });
  assert.deepEqual(
    Object.keys(daemon.ports).filter((name) => name.startsWith('crcl.')),
    ['crcl.irb120_1', 'crcl.ur5e_1']
  );
  await click('editor-leave');
  await until('the cell in the view', () =>
    inPage(
      ({state, robots}) =>
        state.live.robots.length === 2 &&
        robots.length === 2 &&
        robots.every(({arm}) => arm !== null)
    )
  );
  const status = execFileSync(join(bin, 'aprsim'), ['status', '--ports-file', daemon.portsFile], {
    encoding: 'utf8'
  });
  assert.match(status, /ur5e_1/);
  assert.doesNotMatch(status, /fanuc/);
});

test('both arms move by CRCL, and the page shows it', async () => {
  await inPage((view) => view.state.connection.request({case: 'resume', value: {}}));
  for (const [index, name] of ['ur5e_1', 'irb120_1'].entries()) {
    const robot = await CrclClient.open(daemon.ports[`crcl.${name}`]);
    await robot.run('InitCanonType');
    const joints = [...(await robot.status()).matchAll(/<JointPosition>([^<]*)</g)].map(([, at]) =>
      Number(at)
    );
    assert.equal(joints.length, 6, name);
    joints[0] += 10;
    joints[4] -= 5;
    await robot.moveJoints(joints);
    robot.close();
    await until(`${name} in the page`, () =>
      page.evaluate(
        ([at, goal]) => {
          const {state} = document.querySelector('main.stage').view;
          return (
            Math.abs((state.live.robots[at].joints[0].positionRad * 180) / Math.PI - goal) < 0.1
          );
        },
        [index, joints[0]]
      )
    );
  }
  await page.getByRole('tab', {name: 'CRCL', exact: true}).click();
  await until('the traffic of the new robots', async () =>
    /ur5e_1/.test(await page.locator('#panel-CRCL').textContent())
  );
});

test('the belt runs by one Modbus server and is metered by the other', async () => {
  const tray = () => inPage(({state}) => state.live.bodies[0].bodyInWorld.positionM.x);
  const [before, x] = [await readTwo(daemon.ports['modbus.meter']), await tray()];
  await writeRegister(daemon.ports['modbus.drive'], 0, 200);
  await writeRegister(daemon.ports['modbus.drive'], 2, 1);
  await writeRegister(daemon.ports['modbus.drive'], 1, 1);
  await until(
    'the belt to move',
    async () => (await readTwo(daemon.ports['modbus.meter'])) > before + 1000
  );
  await until('the tray to move', async () => Math.abs((await tray()) - x) > 0.05);
  await writeRegister(daemon.ports['modbus.drive'], 1, 0);
  assert.deepEqual(page.complaints, []);
});
