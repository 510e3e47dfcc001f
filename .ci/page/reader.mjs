// Pages as their readers open them. What is wrong is collected in `problems`.
import { readFileSync } from 'node:fs';
import { createRequire } from 'node:module';
import { chromium } from 'playwright-core';

const axe = readFileSync(createRequire(import.meta.url).resolve('axe-core/axe.min.js'), 'utf8');
export const problems = new Set();
export const check = (holds, problem) => { if (!holds) problems.add(problem); };
const LAUNCH = {
    executablePath: '/usr/bin/chromium',
    args: ['--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run', '--disable-background-networking',
        '--disable-component-update', '--disable-sync'],
};
export const browser = await chromium.launch(LAUNCH);

/** A browser that shows where something can be scrolled, which is hidden where there is no screen. */
export const launch_with_scrollbars = () => chromium.launch({ ...LAUNCH, ignoreDefaultArgs: ['--hide-scrollbars'] });

/** The page at `url`; whatever it throws, or asks for beyond `own`, is a problem. */
export async function open(url, own, where, options) {
    const page = await (await browser.newContext(options)).newPage();
    page.on('pageerror', error => check(false, `${where}: console: ${error}`));
    page.on('request', it => {
        const is_own = it.url().startsWith(own) || it.url().startsWith('data:');
        check(is_own, `${where}: request: ${it.url()}`);
    });
    // A page that is a single file logs nothing, either.
    if (own === url) {
        page.on('console', it => check(false, `${where}: console: ${it.type()}: ${it.text()}`));
        page.on('requestfailed', it => check(false, `${where}: failed request: ${it.url()}`));
    }
    await page.goto(url);
    return page;
}

export async function check_width(page, where) {
    const wide = await page.evaluate(() => document.documentElement.scrollWidth - window.innerWidth);
    check(wide <= 0, `${where}: ${wide} px too wide`);
}

/** Looks at what `context` selects by the rules of axe that have one of these tags, of which at least `n_rules` must apply. */
export async function check_access(page, where, tags, context = 'html', n_rules = 11) {
    await page.evaluate(axe);
    const { violations, passes } = await page.evaluate(
        ([within, values]) => window.axe.run(within, { runOnly: { type: 'tag', values } }), [context, tags]);
    check(passes.length >= n_rules, `${where}: axe looked at ${passes.length} rules only`);
    for (const { id, help, nodes } of violations) {
        check(false, `${where}: axe: ${id}: ${help}: ${nodes.slice(0, 3).map(it => it.html.slice(0, 160)).join(' | ')}`);
    }
}

/** Prints the problems, and ends the program. */
export async function end(summary) {
    await browser.close();
    for (const problem of problems) console.error(problem);
    console.log(summary);
    process.exit(problems.size ? 1 : 0);
}
