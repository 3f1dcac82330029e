// The page of a viewer without permission.
import assert from 'node:assert/strict';
import {execFileSync} from 'node:child_process';
import {mkdtempSync, writeFileSync} from 'node:fs';
import {tmpdir} from 'node:os';
import {join} from 'node:path';
import {after, before, test} from 'node:test';
import {Daemon, bin, openPlainBrowser, openPage, stopAll, until} from './harness.mjs';

let browser;
before(async () => (browser = await openPlainBrowser()));
after(async () => {
  await browser?.close();
  await stopAll();
});

const guarded = [
  'play',
  'reset',
  'stop-cell',
  'init-fanuc',
  'stop-fanuc',
  'fanuc-gripper-open',
  'jog fanuc joint 1 plus',
  'run-demo',
  'run-scenario',
  'edit-scenario',
  'scenario-editor',
  'stop-program',
  'inject'
];

test('a read-only view disables every control and says why', async () => {
  const daemon = await Daemon.start(['--set', 'web.control=false']);
  const page = await openPage(browser, daemon);
  await until('a reason', async () =>
    /read-only/.test(await page.locator('.banner').textContent())
  );
  for (const id of guarded) {
    assert.ok(await page.getByTestId(id).isDisabled(), id);
    const reason = await page
      .getByTestId(id)
      .evaluate((control) => control.closest('fieldset')?.title || control.title);
    assert.match(reason, /read-only/, id);
  }
  await daemon.stop();
});

test('a token unlocks', async () => {
  const file = join(mkdtempSync(join(tmpdir(), 'aprsim-token-')), 'token');
  writeFileSync(file, 'open-sesame\n');
  const daemon = await Daemon.start(['--token-file', file]);
  const page = await openPage(browser, daemon);
  await until('the form', () => page.getByLabel('Access token').isVisible());
  assert.ok(await page.getByTestId('play').isDisabled());
  await page.getByLabel('Access token').fill('wrong-token');
  await page.getByRole('button', {name: 'Unlock'}).click();
  await until('a refusal', async () =>
    /wrong token/.test(await page.locator('.toasts').textContent())
  );
  await page.getByLabel('Access token').fill('open-sesame');
  await page.getByRole('button', {name: 'Unlock'}).click();
  await until('control', () => page.getByTestId('play').isEnabled());
  await page.getByTestId('play').click();
  await until(
    'a paused cell',
    async () => (await page.getByTestId('play').textContent()) === 'Play'
  );
  await daemon.stop();
});

test('over TLS, a token lets do what its role may', async () => {
  const folder = mkdtempSync(join(tmpdir(), 'aprsim-access-'));
  const file = (name) => join(folder, name);
  const certificate = ['-keyout', file('key'), '-out', file('cert'), '-subj', '/CN=cell'];
  execFileSync('openssl', ['req', '-x509', '-newkey', 'rsa:2048', '-nodes', ...certificate], {
    stdio: 'ignore'
  });
  const add = (name) =>
    execFileSync(
      join(bin, 'aprsimd'),
      ['token', 'add', name, '--role', name, '--file', file('access')],
      {encoding: 'utf8', stdio: ['ignore', 'pipe', 'ignore']}
    ).trim();
  const tokens = {operate: add('operate'), admin: add('admin')};
  const keys = [
    `tls.certificate=${file('cert')}`,
    `tls.key=${file('key')}`,
    `access.file=${file('access')}`
  ];
  const daemon = await Daemon.start(keys.flatMap((key) => ['--set', key]));
  const served = {url: daemon.url.replace('http:', 'https:')};
  const page = await openPage(browser, served, {
    ignoreHTTPSErrors: true,
    query: `#token=${tokens.operate}`
  });
  await until('control', () => page.getByTestId('play').isEnabled());
  assert.equal(new URL(page.url()).hash, '', 'the token leaves the address');
  for (const [id, role] of [
    ['inject', 'inject'],
    ['reset', 'admin'],
    ['run-demo', 'admin']
  ]) {
    const control = page.getByTestId(id);
    assert.ok(await control.isDisabled(), id);
    const title = await control.evaluate((c) => c.closest('fieldset')?.title || c.title);
    assert.equal(title, `This needs the role ${role}; yours is operate.`);
  }
  await page.context().close();
  const admin = await openPage(browser, served, {
    ignoreHTTPSErrors: true,
    query: `#token=${tokens.admin}`
  });
  await until('every control', () => admin.getByTestId('reset').isEnabled());
  await daemon.stop();
});
