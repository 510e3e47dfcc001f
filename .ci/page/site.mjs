// Opens pages of the book as its readers do: site.mjs BOOK PICTURES. Everything that is wrong is printed, and makes it fail.
import { pathToFileURL } from 'node:url';
import { check_access, check_width, end, open, problems } from './reader.mjs';

const PAGES = ['index', 'docs/your-detector', 'docs/leaderboard', 'docs/walkthroughs/ten-minutes', 'command-line',
    'gallery'];
const [book, pictures] = process.argv.slice(2);
const home = pathToFileURL(`${book}/`).href;
for (const colorScheme of ['light', 'dark']) {
    for (const width of [390, 1440]) {
        for (const name of PAGES) {
            const where = `${name}, ${colorScheme}, ${width} px`;
            const page = await open(`${home}${name}.html`, home, where, { viewport: { width, height: 900 }, colorScheme });
            await check_width(page, where);
            await page.screenshot({ path: `${pictures}/${name.replaceAll('/', '-')}-${colorScheme}-${width}.png` });
            // A page of text alone is all headings, links and colours.
            await check_access(page, where, ['wcag2a', 'wcag2aa', 'wcag21aa'], 'main', 1);
            await page.context().close();
        }
    }
}
// A word that stands in one place is found there.
const page = await open(`${home}index.html?search=robustness`, home, 'search', {});
await page.waitForSelector('#mdbook-searchresults li', { timeout: 30_000 })
    .catch(() => problems.add('the search finds nothing'));
await end(`${PAGES.length} pages at two widths, light and dark; pictures in ${pictures}`);
