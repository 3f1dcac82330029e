// A recorded run that is served: the page shows it and its whole past, wires and all, and takes no
// commands; also where the scene changed on the way.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {mkdtempSync, rmSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import {
  bin,
  CrclClient,
  Daemon,
  openPlainBrowser,
  openPage,
  stopAll,
  until,
  writeRegister
} from './harness.mjs';

let daemon, browser, page, folder;
const seen = {};

before(async () => {
  folder = mkdtempSync(join(tmpdir(), 'aprsim-replay-'));
  const journal = join(folder, 'run.journal');
  const recorded = await Daemon.start(['--no-web', '--journal', journal]);
  const aprsim = (...words) =>
    execFileSync(join(bin, 'aprsim'), [
      ...words,
      '--ports-file',
      join(recorded.directory, 'ports.json')
    ]).toString();
  const step = () => Number(JSON.parse(aprsim('status', '--json')).step);
  // So that there is a moment before the first command.
  await until('the first steps', () => step() > 100);
  const client = await CrclClient.open(recorded.ports['crcl.fanuc']);
  await client.run('InitCanonType');
  await client.moveJoints([20, 0, 0, 0, 0, 0]);
  await writeRegister(recorded.ports.modbus, 0x8002, 10000);
  seen.moved = step();
  aprsim('scene', 'spawn', 'sku_part_large_gear', 'spare', '--at', '0.3', '-1', '1.2');
  seen.spawned = step();
  await client.moveJoints([0, 0, 0, 0, 0, 0]);
  aprsim('reset', '--scene', 'aprs_2024');
  await client.run('InitCanonType');
  await client.moveJoints([10, 0, 0, 0, 0, 0]);
  seen.last = step();
  client.close();
  await recorded.stop();
  daemon = await Daemon.start(['--replay', journal, '--serve', '--speed', 'max']);
  browser = await openPlainBrowser();
  page = await openPage(browser, daemon);
});
after(async () => {
  await browser?.close();
  await stopAll();
  rmSync(folder, {recursive: true, force: true});
});

/** Shown state. */
const shown = () =>
  page.evaluate(() => {
    const {view} = document.querySelector('main.stage');
    const {snapshot, past, cell, appearance, live} = view.state;
    return {
      past: past !== null,
      epoch: Number(snapshot.epoch),
      step: Number(snapshot.step),
      joint: snapshot.robots[0].joints[0].positionRad,
      scene: cell.scene,
      bodies: cell.bodies.map(({name}) => name),
      states: snapshot.bodies.length,
      fixed: appearance.fixed.length,
      live: Number(live.step)
    };
  });
const goTo = async (place) => {
  await page.getByTestId('moment').fill(String(place));
  return until(`place ${place}`, async () => {
    const now = await shown();
    return now.past && now;
  });
};
const tab = (name) => page.getByRole('tab', {name}).click();

test('it comes to its end and takes no commands', async () => {
  const end = await until('the end of the run', async () => {
    const now = await shown();
    return now.epoch === 1 && now.step >= seen.last - 50 && now;
  });
  assert.equal(end.scene, 'aprs_2024');
  assert.ok(Math.abs(end.joint - (10 * Math.PI) / 180) < 1e-6, end.joint);
  assert.equal(end.states, end.bodies.length);
  const reset = page.getByTestId('reset');
  assert.ok(await reset.isDisabled());
  assert.match(await reset.getAttribute('title'), /recorded run/);
});

test('the line goes to all of it, through every scene', async () => {
  const now = await shown();
  // A step after the motion; the slider counts the steps of all epochs.
  const moved = await until('that moment', async () => {
    const at = await goTo(seen.moved);
    return at.step === seen.moved && at.epoch === 0 && at;
  });
  assert.equal(moved.scene, 'aprs');
  assert.ok(Math.abs(moved.joint - (20 * Math.PI) / 180) < 1e-6, moved.joint);
  assert.ok(!moved.bodies.includes('spare'));
  assert.ok(moved.fixed > 0);
  assert.equal(moved.states, moved.bodies.length);
  assert.notDeepEqual(moved.bodies, now.bodies);
  const spawned = await until('the spare part', async () => {
    const at = await goTo(seen.spawned + 100);
    return at.bodies.includes('spare') && at;
  });
  assert.equal(spawned.states, spawned.bodies.length);
  assert.equal(spawned.scene, 'aprs');
  await page.getByTestId('past-now').click();
  await until('the present', async () => {
    const at = await shown();
    return !at.past && at.scene === 'aprs_2024';
  });
});

test('what went over the wires is there at its time', async () => {
  await tab('CRCL');
  const rows = page.getByTestId('crcl-rows').locator('tr');
  await until('the commands', async () => {
    const texts = await rows.allTextContents();
    return (
      texts.filter((text) => /ActuateJoints/.test(text)).length === 3 &&
      texts.filter((text) => /Done/.test(text)).length >= 5
    );
  });
  await until('no command yet', async () => {
    await goTo(1);
    return (await rows.count()) === 0;
  });
  await goTo(seen.moved);
  await until('the first motion', async () =>
    /ActuateJoints/.test((await rows.allTextContents()).join('\n'))
  );
  await tab('Modbus');
  const units = page.getByTestId('modbus-rows').locator('tr');
  await goTo(seen.spawned);
  await until('the register', async () => (await units.count()) >= 2);
  assert.deepEqual(page.complaints, []);
});
