/* here.js - a page with ?here after its name stands within index.html: picture above knobs, as high as both are. The index is
   told by messages, since pages from the disk may not look into each other: the height, whether a picture is there, what
   went wrong, and milliseconds from asking for a frame to its end. */
'use strict';

if (new URLSearchParams(location.search).has('here')) {
    const name = location.pathname.replace(/.*\/|\.html$/g, '');
    const tell = (what) => parent.postMessage({ dapple: name, ...what }, '*');
    let last = '';
    document.documentElement.classList.add('here');
    addEventListener('DOMContentLoaded', () => {
        const body = document.body, picture = document.getElementById('picture'), message = document.getElementById('message');
        new ResizeObserver(() => tell({ high: Math.ceil(body.getBoundingClientRect().height) })).observe(body);
        new MutationObserver(() => tell({ message: message.textContent })).observe(message, { childList: true, characterData: true, subtree: true });
        setInterval(() => {
            const facts = { frames: window.dappleFrames || 0, cost: window.dappleCost || 0, width: picture.width, height: picture.height };
            if (JSON.stringify(facts) !== last) tell(facts);
            last = JSON.stringify(facts);
        }, 250);
    });
}
