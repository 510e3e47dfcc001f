// Opens a report page as its readers do. Everything that is wrong is printed, and makes the check fail.
import { readFileSync, statSync } from 'node:fs';
import { createRequire } from 'node:module';
import { pathToFileURL } from 'node:url';
import { chromium } from 'playwright-core';

const MOST_BYTES = 2_000_000;
const WIDTHS = [360, 820, 1440];
const PRINTED_PAGES = 2;

const [file, shots] = process.argv.slice(2);
const url = pathToFileURL(file).href;
const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const problems = [];
const check = (holds, problem) => { if (!holds) problems.push(problem); };

const bytes = statSync(file).size;
check(bytes < MOST_BYTES, `the page has ${bytes} bytes`);

const browser = await chromium.launch({
    executablePath: '/usr/bin/chromium',
    args: ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
        '--disable-component-update', '--disable-sync'],
});

/** The page as it is opened by a reader; whatever it logs or asks for beyond itself is a problem. */
async function open(options) {
    const context = await browser.newContext(options);
    const page = await context.newPage();
    page.on('console', message => check(false, `console: ${message.type()}: ${message.text()}`));
    page.on('pageerror', error => check(false, `console: ${error}`));
    page.on('request', request => {
        const is_own = request.url() === url || request.url().startsWith('data:');
        check(is_own, `request: ${request.url()}`);
    });
    page.on('requestfailed', request => check(false, `failed request: ${request.url()}`));
    await page.goto(url);
    return page;
}

/** Everything that Tab should reach, and what it does reach. */
async function tab_order(page) {
    const expected = await page.evaluate(() => {
        const all = [...document.querySelectorAll('a[href], summary, button, input, select, textarea, [tabindex="0"]')];
        const shown = all.filter(it => it.checkVisibility());
        shown.forEach((it, index) => it.setAttribute('data-place', index));
        return shown.map(it => it.outerHTML.slice(0, 80));
    });
    const reached = new Set();
    for (let step = 0; step < expected.length + 2; step += 1) {
        await page.keyboard.press('Tab');
        const place = await page.evaluate(() => {
            const it = document.activeElement;
            const { outlineStyle, outlineWidth } = getComputedStyle(it);
            const is_seen = outlineStyle !== 'none' && parseFloat(outlineWidth) >= 2;
            return it.dataset.place === undefined ? null : [Number(it.dataset.place), is_seen];
        });
        if (place) {
            reached.add(place[0]);
            check(place[1], `no visible focus: ${expected[place[0]]}`);
        }
    }
    expected.forEach((it, index) => check(reached.has(index), `Tab does not reach ${it}`));
    return expected.length;
}

let reachable = 0;
for (const colorScheme of ['light', 'dark']) {
    for (const width of WIDTHS) {
        const page = await open({ viewport: { width, height: 900 }, colorScheme });
        for (const state of ['as it opens', 'with everything open']) {
            const wide = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
            check(wide <= 0, `${wide} px too wide at ${width} px, ${state}`);
            const ending = state === 'as it opens' ? '' : '-open';
            await page.screenshot({ path: `${shots}/${colorScheme}-${width}${ending}.png`, fullPage: true });
            await page.evaluate(() => document.querySelectorAll('details').forEach(it => { it.open = true; }));
        }
        if (colorScheme === 'light' && width === 820) {
            reachable = await tab_order(page);
        }
        await page.context().close();
    }
    // The page allows no scripts, so axe needs leave to run.
    for (const width of [360, 1440]) {
        const page = await open({ viewport: { width, height: 900 }, colorScheme, bypassCSP: true });
        await page.evaluate(() => document.querySelectorAll('details').forEach(it => { it.open = true; }));
        await page.evaluate(axe);
        const tags = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice'];
        const { violations, passes } = await page.evaluate(values => window.axe.run({ runOnly: { type: 'tag', values } }), tags);
        check(passes.length > 10, `axe looked at ${passes.length} rules only`);
        for (const { id, help, nodes } of violations) {
            check(false, `axe, ${colorScheme}, ${width} px: ${id}: ${help}: ${nodes.slice(0, 3).map(it => it.html.slice(0, 160)).join(' | ')}`);
        }
        await page.context().close();
    }
}

const page = await open({});
const pdf = await page.pdf({ path: `${shots}/page.pdf`, preferCSSPageSize: true });
const printed = pdf.toString('latin1').match(/\/Type\s*\/Page\b(?!s)/g)?.length ?? 0;
check(printed === PRINTED_PAGES, `${printed} printed pages instead of ${PRINTED_PAGES}`);
await browser.close();

for (const problem of new Set(problems)) {
    console.error(problem);
}
console.log(`${bytes} bytes, ${printed} printed pages, ${reachable} places for Tab; pictures in ${shots}`);
process.exit(problems.length === 0 ? 0 : 1);
