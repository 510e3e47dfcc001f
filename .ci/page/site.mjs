// Opens pages of the book as its readers do: site.mjs BOOK PICTURES. Everything that is wrong is printed, and makes the check
// fail.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { pathToFileURL } from 'node:url';
import { chromium } from 'playwright-core';

const PAGES = ['index', 'docs/your-detector', 'docs/leaderboard', 'docs/walkthroughs/ten-minutes', 'command-line',
    'gallery'];
const [book, pictures] = process.argv.slice(2);
const home = pathToFileURL(`${book}/`).href;
const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
const problems = new Set();
const browser = await chromium.launch({ executablePath: '/usr/bin/chromium', args: ['--no-sandbox', '--disable-gpu'] });

for (const colorScheme of ['light', 'dark']) {
    for (const width of [390, 1440]) {
        for (const name of PAGES) {
            const where = `${name}, ${colorScheme}, ${width} px`;
            const page = await browser.newPage({ viewport: { width, height: 900 }, colorScheme });
            page.on('pageerror', error => problems.add(`${where}: ${error}`));
            page.on('request', it => {
                const is_own = it.url().startsWith(home) || it.url().startsWith('data:');
                if (!is_own) problems.add(`${where}: asks for ${it.url()}`);
            });
            await page.goto(`${home}${name}.html`);
            const wide = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
            if (wide > 0) problems.add(`${where}: ${wide} px too wide`);
            await page.screenshot({ path: `${pictures}/${name.replaceAll('/', '-')}-${colorScheme}-${width}.png` });
            await page.evaluate(axe);
            const { violations } = await page.evaluate(
                () => window.axe.run('main', { runOnly: ['wcag2a', 'wcag2aa', 'wcag21aa'] }));
            for (const { id, nodes } of violations) {
                problems.add(`${where}: axe: ${id}: ${nodes[0].html.slice(0, 160)}`);
            }
            await page.close();
        }
    }
}
// A word that stands in one place is found there.
const page = await browser.newPage();
await page.goto(`${home}index.html?search=robustness`);
await page.waitForSelector('#mdbook-searchresults li', { timeout: 30_000 })
    .catch(() => problems.add('the search finds nothing'));
await browser.close();
for (const problem of problems) console.error(problem);
console.log(`${PAGES.length} pages at two widths, light and dark; pictures in ${pictures}`);
process.exit(problems.size ? 1 : 0);
