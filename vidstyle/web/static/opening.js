// The first picture of a page, until its modules have loaded and know more. A classic script: modules run later.

document.body.insertAdjacentHTML("afterbegin", '<div id="opening"><img src="glance.jpg" alt=""><p role="status">Opening…</p></div>');
