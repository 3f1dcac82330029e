// The site of docs/build, as the daemon serves it: no complaint of the browser, search, the page's link.
import assert from 'node:assert/strict';
import {after, before, test} from 'node:test';
import {Daemon, openBrowser, stopAll, until} from './harness.mjs';

let browser, daemon;
before(async () => {
  daemon = await Daemon.start();
  browser = await openBrowser();
});
after(async () => {
  await browser?.close();
  await stopAll();
});

async function open(path) {
  const page = await (await browser.newContext({viewport: {width: 1280, height: 800}})).newPage();
  page.complaints = [];
  page.on('console', (message) => {
    if (['error', 'warning'].includes(message.type())) page.complaints.push(message.text());
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
