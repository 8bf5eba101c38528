// The search of the site runs in a Worker, which browsers refuse to pages that are opened from a folder.
// There it runs in a hidden frame that has the same two functions, postMessage and importScripts.
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      const frame = document.createElement("iframe");
      frame.hidden = true;
      document.body.append(frame);
      this.inside = frame.contentWindow;
      addEventListener("message", (event) => {
        if (event.source !== this.inside) return;
        const heard = new MessageEvent("message", { data: event.data });
        this.dispatchEvent(heard);
        if (this.onmessage) this.onmessage(heard);
      });
      const prepared =
        'window.postMessage = (data) => parent.postMessage(data, "*");' +
        "window.importScripts = (...urls) => urls.reduce((before, url) => before.then(() => new Promise((done) => {" +
        'const script = document.createElement("script"); script.src = url; script.onload = done;' +
        "document.head.append(script); })), Promise.resolve());";
      this.loaded = new Promise((done) => frame.addEventListener("load", done));
      this.inside.document.open();
      this.inside.document.write(`<script>${prepared}<\/script><script src="${url}"><\/script>`);
      this.inside.document.close();
    }

    postMessage(data) {
      this.loaded.then(() => this.inside.dispatchEvent(new MessageEvent("message", { data })));
    }
  };
}
