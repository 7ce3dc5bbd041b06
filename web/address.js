// What is chosen and where the view is, kept in the address so that it can be sent to others:
// #map=NAME&session=ID&answer=17&tab=maps&compare=OTHER&x=1.00&y=2.00&z=5

export function readAddress(hash) {
  const asked = new URLSearchParams(hash.slice(1));
  const numbers = ['x', 'y', 'z'].map((name) => Number.parseFloat(asked.get(name)));
  const [x, y, z] = numbers;
  return {
    map: asked.get('map'),
    session: asked.get('session'),
    answer: /^\d+$/.test(asked.get('answer') ?? '') ? Number(asked.get('answer')) : null,
    compare: asked.get('compare'),
    tab: asked.get('tab') === 'maps' ? 'maps' : 'robots',
    view: numbers.every(Number.isFinite) ? { x, y, z } : null,
  };
}

export function addressOf({ map, session, answer = null, tab, compare, view }) {
  const query = new URLSearchParams();
  if (map) query.set('map', map);
  if (session) query.set('session', session);
  if (session && answer !== null) query.set('answer', String(answer));
  if (tab === 'maps') query.set('tab', tab);
  if (compare) query.set('compare', compare);
  if (view) {
    query.set('x', view.x.toFixed(2));
    query.set('y', view.y.toFixed(2));
    query.set('z', String(view.z));
  }
  return `#${query}`;
}
