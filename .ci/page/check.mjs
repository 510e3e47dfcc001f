// Opens a report page as its readers do: check.mjs PAGE PICTURES. Everything that is wrong is printed, and makes it fail.
import { statSync } from 'node:fs';
import { pathToFileURL } from 'node:url';
import { check, check_access, check_width, end, open } from './reader.mjs';

const MOST_BYTES = 2_000_000;
// Tables of several detectors come apart.
const MOST_PRINTED_PAGES = 4;
const TAGS = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'wcag22aa', 'best-practice'];
const [file, shots] = process.argv.slice(2);
const url = pathToFileURL(file).href;
const bytes = statSync(file).size;
check(bytes < MOST_BYTES, `the page has ${bytes} bytes`);

const open_details = page => page.evaluate(() => document.querySelectorAll('details').forEach(it => { it.open = true; }));

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
    for (const width of [360, 820, 1440]) {
        const where = `${colorScheme}, ${width} px`;
        const options = { viewport: { width, height: 900 }, colorScheme };
        const page = await open(url, url, where, options);
        await check_width(page, where);
        await page.screenshot({ path: `${shots}/${colorScheme}-${width}.png`, fullPage: true });
        await open_details(page);
        await check_width(page, `${where}, with everything open`);
        await page.screenshot({ path: `${shots}/${colorScheme}-${width}-open.png`, fullPage: true });
        if (colorScheme === 'light' && width === 820) reachable = await tab_order(page);
        await page.context().close();
        if (width === 820) continue;
        // The page allows no scripts, so axe needs leave to run.
        const scripted = await open(url, url, where, { ...options, bypassCSP: true });
        await open_details(scripted);
        await check_access(scripted, where, TAGS);
        await scripted.context().close();
    }
}
const page = await open(url, url, 'print', {});
const pdf = await page.pdf({ path: `${shots}/page.pdf`, preferCSSPageSize: true });
const printed = pdf.toString('latin1').match(/\/Type\s*\/Page\b(?!s)/g)?.length ?? 0;
check(printed > 0 && printed <= MOST_PRINTED_PAGES, `${printed} printed pages, more than ${MOST_PRINTED_PAGES}`);
await end(`${bytes} bytes, ${printed} printed pages, ${reachable} places for Tab; pictures in ${shots}`);
