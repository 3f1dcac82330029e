// The site of docs/build, as the daemon serves it: no complaint of the browser, search, the page's links.
import assert from 'node:assert/strict';
import {after, afterEach, before, test} from 'node:test';
import {Daemon, openPlainBrowser, stopAll, until} from './harness.mjs';

let browser, daemon;
before(async () => {
  daemon = await Daemon.start();
  browser = await openPlainBrowser();
});
// A context keeps its connections, of which the daemon has a limited number.
afterEach(async () => {
  for (const context of browser.contexts()) await context.close();
});
after(async () => {
  await browser?.close();
  await stopAll();
});

async function open(path) {
  const page = await (await browser.newContext({viewport: {width: 1280, height: 800}})).newPage();
  page.complaints = [];
  page.on('console', (message) => {
    // The browser asks for an icon of the host on its own now and then.
    const {url} = message.location();
    if (url.endsWith('/favicon.ico')) return;
    if (['error', 'warning'].includes(message.type())) {
      page.complaints.push(`${message.text()} ${url}`);
    }
  });
  page.on('pageerror', (error) => page.complaints.push(String(error)));
  page.on('requestfailed', (request) => page.complaints.push(request.url()));
  await page.goto(new URL(path, daemon.url).href);
  return page;
}

test('/docs leads to the documents, whose pages the browser accepts', async () => {
  const page = await open('docs');
  await page.waitForURL('**/docs/');
  assert.match(await page.title(), /aprsim/);
  for (const path of [
    'docs/tutorial.html',
    'docs/reference/events.html',
    'docs/ARCHITECTURE.html'
  ]) {
    const other = await open(path);
    await other.waitForSelector('article h1');
    const missing = await other.evaluate(() =>
      [...document.images].filter((image) => !image.naturalWidth).map((image) => image.src)
    );
    assert.deepEqual(missing, [], path);
    assert.deepEqual(other.complaints, [], path);
  }
  assert.deepEqual(page.complaints, []);
});

test('search finds a configuration key', async () => {
  const page = await open('docs/');
  await page.locator('input[data-md-component=search-query]').click();
  await page.keyboard.type('yield_after_ms');
  await until('a result', async () =>
    (await page.locator('.md-search-result__item').allTextContents()).some((text) =>
      /Configuration keys/.test(text)
    )
  );
  assert.deepEqual(page.complaints, []);
});

test('the page links to the documents', async () => {
  const page = await open('');
  const link = page.getByRole('link', {name: 'Docs'});
  assert.equal(await link.getAttribute('href'), 'docs/');
});

test('each panel links to the documents that explain it', async () => {
  const page = await open('');
  await page.getByRole('tab').first().waitFor();
  const tabs = await page.getByRole('tab').all();
  assert.equal(tabs.length, 9);
  for (const tab of tabs) {
    await tab.click();
    const link = page.locator('.tabrow a.explain:visible');
    assert.equal(await link.count(), 1);
    const name = await tab.evaluate((button) => button.firstChild.textContent);
    assert.equal(await link.getAttribute('aria-label'), `Documentation: ${name}`);
  }
  const targets = await page.evaluate(() =>
    [...document.querySelectorAll('a.explain')].map((link) => link.href)
  );
  assert.equal(new Set(targets).size, 9, targets.join(' '));
  for (const target of new Set(targets)) {
    const answer = await fetch(target);
    assert.equal(answer.status, 200, target);
    assert.match(await answer.text(), /<article/, target);
  }
});
