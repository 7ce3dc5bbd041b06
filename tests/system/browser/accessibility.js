// What can be checked of WCAG 2.1 AA in the page itself. Returns a list of faults.
// Names of controls come from the browser's accessibility tree and are checked beside this.
(() => {
  const faults = [];
  const where = (node) => `${node.tagName.toLowerCase()}${node.id ? `#${node.id}` : ''}${
    typeof node.className === 'string' && node.className ? `.${node.className.split(' ').join('.')}` : ''}`;
  const isVisible = (node) => node.checkVisibility({ checkOpacity: true, checkVisibilityCSS: true });

  const channels = (text) => text.match(/[\d.]+/g).map(Number);
  const luminance = ([red, green, blue]) => [red, green, blue].map((value) => value / 255)
    .map((value) => (value <= 0.04045 ? value / 12.92 : ((value + 0.055) / 1.055) ** 2.4))
    .reduce((sum, value, i) => sum + value * [0.2126, 0.7152, 0.0722][i], 0);
  const contrast = (a, b) => {
    const [light, dark] = [luminance(a), luminance(b)].sort((x, y) => y - x);
    return (light + 0.05) / (dark + 0.05);
  };

  // The colour behind a node: the nearest ancestor that is not transparent.
  function backgroundOf(node) {
    for (let at = node; at; at = at.parentElement) {
      const color = channels(getComputedStyle(at).backgroundColor);
      if (color.length === 3 || color[3] > 0.99) return color;
    }
    return [255, 255, 255];
  }

  function checkText(node) {
    const style = getComputedStyle(node);
    const size = Number.parseFloat(style.fontSize);
    const isLarge = size >= 24 || (size >= 18.66 && Number(style.fontWeight) >= 700);
    const ratio = contrast(channels(style.color), backgroundOf(node));
    if (ratio < (isLarge ? 3 : 4.5)) faults.push(`1.4.3 contrast ${ratio.toFixed(2)}: ${where(node)} "${node.textContent.trim().slice(0, 30)}"`);
  }

  const texts = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  const seen = new Set();
  while (texts.nextNode()) {
    const parent = texts.currentNode.parentElement;
    if (!texts.currentNode.data.trim() || seen.has(parent) || !isVisible(parent)) continue;
    if (parent.closest('[disabled], noscript, script')) continue;
    seen.add(parent);
    checkText(parent);
  }

  // 1.4.11: the edges of fields and buttons against what is behind them.
  for (const node of document.querySelectorAll('input:not([type=checkbox]):not([type=range]):not([type=file]), select, textarea')) {
    if (!isVisible(node)) continue;
    const ratio = contrast(channels(getComputedStyle(node).borderTopColor), backgroundOf(node.parentElement));
    if (ratio < 3) faults.push(`1.4.11 edge ${ratio.toFixed(2)}: ${where(node)}`);
  }

  if (!document.documentElement.lang) faults.push('3.1.1 no language');
  if (!document.title) faults.push('2.4.2 no title');
  if (document.querySelectorAll('h1').length !== 1) faults.push('not exactly one h1');
  for (const landmark of ['header', 'main', 'nav', 'aside']) {
    if (!document.querySelector(landmark)) faults.push(`1.3.1 no ${landmark}`);
  }

  let level = 1;
  for (const heading of [...document.querySelectorAll('h1, h2, h3, h4')].filter(isVisible)) {
    const next = Number(heading.tagName[1]);
    if (next > level + 1) faults.push(`1.3.1 heading ${next} after ${level}: "${heading.textContent}"`);
    level = next;
  }

  const ids = [...document.querySelectorAll('[id]')].map(({ id }) => id);
  for (const id of ids.filter((id, i) => ids.indexOf(id) !== i)) faults.push(`4.1.1 id ${id} is there twice`);
  for (const name of ['aria-labelledby', 'aria-describedby', 'aria-controls']) {
    for (const node of document.querySelectorAll(`[${name}]`)) {
      for (const id of node.getAttribute(name).split(' ')) if (!document.getElementById(id)) faults.push(`4.1.2 ${name}=${id} names nothing`);
    }
  }
  for (const table of document.querySelectorAll('table')) {
    if (!table.caption || !table.querySelector('th[scope]')) faults.push('1.3.1 a table without caption or scopes');
  }
  // 1.4.10: nothing makes the page scroll sideways.
  if (document.documentElement.scrollWidth > window.innerWidth) {
    faults.push(`1.4.10 the page is ${document.documentElement.scrollWidth} px wide in ${window.innerWidth} px`);
  }
  return faults;
})()
