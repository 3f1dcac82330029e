// "Save this incident": a file that runs again without the daemon that it came from.
import assert from 'node:assert/strict';
import {execFile} from 'node:child_process';
import {mkdtempSync, rmSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import {promisify} from 'node:util';
import {CrclClient, Daemon, openPlainBrowser, openPage, stopAll, until} from './harness.mjs';

let browser, folder;
before(async () => {
  browser = await openPlainBrowser();
  folder = mkdtempSync(join(tmpdir(), 'aprsim-incident-'));
});
after(async () => {
  await browser?.close();
  await stopAll();
  rmSync(folder, {recursive: true, force: true});
});

const replay = (file) =>
  promisify(execFile)(join(process.env.APRSIM_BIN_DIR, 'aprsimd'), ['--replay', file]);

test('what is saved on the page is run again to the same states', async () => {
  const daemon = await Daemon.start();
  const page = await openPage(browser, daemon);
  const client = await CrclClient.open(daemon.ports['crcl.fanuc']);
  await client.run('InitCanonType');
  await client.moveJoints([5, 0, 0, 0, 0, 0]);
  client.close();
  await page.getByRole('tab', {name: 'Faults'}).click();
  const [saved] = await Promise.all([
    page.waitForEvent('download'),
    page.getByTestId('save-incident').click()
  ]);
  assert.match(saved.suggestedFilename(), /^aprsim-[0-9a-f]+-epoch0-step\d+\.journal$/);
  const file = join(folder, 'saved.journal');
  await saved.saveAs(file);
  await daemon.stop();
  const {stdout} = await replay(file);
  assert.match(stdout, /[1-9]\d* commands/);
  assert.match(stdout, /all states are the same/);
  assert.deepEqual(
    page.complaints.filter((line) => !/WebSocket|ERR_/.test(line)),
    []
  );
});

test('where nothing is kept the page says so', async () => {
  const daemon = await Daemon.start(['--set', 'journal.memory_mb=0']);
  const page = await openPage(browser, daemon);
  await page.getByRole('tab', {name: 'Faults'}).click();
  await page.getByTestId('save-incident').click();
  await until('the message', async () =>
    /records no incidents/.test(await page.locator('.toasts').textContent())
  );
});
