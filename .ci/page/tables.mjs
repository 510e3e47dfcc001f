// Looks for what is cut off sideways on report pages, on screens of several widths and on paper: tables.mjs PICTURES PAGE…
import { basename, dirname } from 'node:path';
import { pathToFileURL } from 'node:url';
import { check, end, launch_with_scrollbars } from './reader.mjs';

const WIDTHS = [390, 768, 1024, 1280, 1440];
// What a page of A4 has between its margins, in pixels.
const PAPER_PX = 718;
const [pictures, ...pages] = process.argv.slice(2);
const browser = await launch_with_scrollbars();

/** What is wider than the room it has, and cannot be scrolled by what is seen and reached by Tab. */
function cut_off() {
    const open = document.documentElement.clientWidth;
    const name = it => it.getAttribute('aria-label') ?? it.caption?.textContent ?? it.outerHTML.slice(0, 60);
    return [...document.querySelectorAll('table, pre, .sheet, .plot, h1, h2, h3, p, ul, dl')].flatMap(it => {
        if (!it.checkVisibility() || it.closest('.hidden')) return [];
        let box = it;
        while (box && getComputedStyle(box).overflowX === 'visible') box = box.parentElement;
        const { overflowX } = box ? getComputedStyle(box) : {};
        if (box && box !== document.body && box !== document.documentElement) {
            if (box.scrollWidth <= box.clientWidth + 1) return [];
            if (overflowX !== 'auto' && overflowX !== 'scroll') return [`${name(it)}: cut off`];
            const bar_px = box.offsetHeight - box.clientHeight - box.clientTop * 2;
            const is_cued = getComputedStyle(box).backgroundImage.includes('gradient') || box.tagName === 'PRE';
            if (bar_px >= 4 && is_cued && box.tabIndex === 0) return [];
            return [`${name(it)}: nothing shows that it scrolls (bar of ${bar_px} px, tabindex ${box.tabIndex})`];
        }
        const beyond = Math.round(it.getBoundingClientRect().left + it.scrollWidth - open);
        return beyond > 1 ? [`${name(it)}: ${beyond} px beyond the edge`] : [];
    });
}

/** How many of the tables of a page have to be scrolled. */
const scrolled = () => [...document.querySelectorAll('.scroll')].filter(it => it.scrollWidth > it.clientWidth + 1).length;

let n_looked_at = 0;
for (const file of pages) {
    const of = basename(dirname(file));
    for (const width of [...WIDTHS, null]) {
        const page = await browser.newPage({ viewport: { width: width ?? PAPER_PX, height: 900 } });
        if (!width) await page.emulateMedia({ media: 'print' });
        await page.goto(pathToFileURL(file).href);
        await page.evaluate(() => document.querySelectorAll('details').forEach(it => { it.open = true; }));
        const where = `${of}, ${width ? `${width} px` : 'print'}`;
        for (const problem of await page.evaluate(cut_off)) check(false, `${where}: ${problem}`);
        if (width === WIDTHS.at(-1)) {
            const n = await page.evaluate(scrolled);
            check(n === 0, `${where}: ${n} tables have to be scrolled on a wide screen`);
        }
        await page.locator('#tables').screenshot({ path: `${pictures}/${where.replaceAll(/\W+/g, '-')}.png` });
        n_looked_at += 1;
        await page.close();
    }
}
await browser.close();
await end(`${n_looked_at} views of ${pages.length} pages; pictures in ${pictures}`);
