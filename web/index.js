/* index.js - runs the scenes of index.html in their places, one at a time: by a click, or, where a GPU draws, when one is
   scrolled into view. A scene is its page in a frame; before and after that there is its picture. */
'use strict';

const scenes = [...document.querySelectorAll('.scene')];
let alive = null;

/* 'none': no WebGL 2; 'slow': the processor draws it, or whoever sits there wants nothing to move by itself; 'fast'. */
function renderer() {
    const gl = document.createElement('canvas').getContext('webgl2');
    if (!gl) return 'none';
    const more = gl.getExtension('WEBGL_debug_renderer_info');
    const name = String(gl.getParameter(more ? more.UNMASKED_RENDERER_WEBGL : gl.RENDERER));
    return /swiftshader|llvmpipe|softpipe|software|basic render/i.test(name) || matchMedia('(prefers-reduced-motion: reduce)').matches ? 'slow' : 'fast';
}

function stop() {
    if (!alive) return;
    alive.querySelector('iframe').remove();             // its context and memory go with it
    alive.classList.remove('alive');
    alive.querySelector('button').textContent = 'Run it here';
    alive.querySelector('.facts').textContent = '';
    alive = null;
}

function start(scene) {
    if (scene === alive) return;
    stop();
    alive = scene;
    const frame = document.createElement('iframe');
    frame.title = scene.querySelector('b').textContent;
    frame.src = `${scene.dataset.page}.html?here`;
    scene.classList.add('alive');
    scene.querySelector('.place').append(frame);
    scene.querySelector('button').textContent = 'Stop';
    scene.querySelector('.facts').textContent = 'starting ...';
}

/* What a page says of itself, see here.js. */
addEventListener('message', ({ source, data }) => {
    const frame = alive && alive.querySelector('iframe');
    if (!frame || source !== frame.contentWindow || data.dapple !== alive.dataset.page) return;
    const facts = alive.querySelector('.facts');
    if (data.high) frame.style.height = `${data.high}px`;
    if (data.message) facts.textContent = data.message;
    else if (data.frames) facts.textContent = `${data.width} x ${data.height} pixels` + (data.cost ? `, ${data.cost.toFixed(data.cost < 10 ? 1 : 0)} ms a frame` : '');
});

const kind = renderer();
if (kind === 'none') {
    document.getElementById('reason').textContent = 'This browser has no WebGL 2, or it is switched off, so the scenes cannot run. '
        + 'These are pictures of them. Chrome 56, Firefox 51, Safari 15 and later have it.';
    document.getElementById('reason').classList.add('shown');
}
for (const scene of scenes) {
    const button = scene.querySelector('button');
    button.hidden = kind === 'none' || (scene.id === 'three' && location.protocol === 'file:');
    button.addEventListener('click', () => {
        if (scene === alive) return stop();
        start(scene);
        scene.querySelector('.place').scrollIntoView({ block: 'center' });      // out of sight browsers draw nothing
    });
}
/* What was stopped by hand, or began another, starts again only when it has been out of sight. */
if (kind === 'fast') {
    const watch = new IntersectionObserver((list) => {
        for (const { target, isIntersecting } of list)
            if (isIntersecting && !target.querySelector('button').hidden) start(target);
    }, { rootMargin: '-35% 0px' });
    for (const scene of scenes) watch.observe(scene);
}
