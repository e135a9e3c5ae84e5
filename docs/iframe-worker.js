/* Search in pages opened from disk, where browsers allow no web workers: the worker's script runs in a hidden frame. */
if (location.protocol === "file:") {
  window.Worker = class extends EventTarget {
    constructor(url) {
      super();
      const frame = document.createElement("iframe");
      frame.hidden = true;
      document.documentElement.append(frame);
      this.scope = frame.contentWindow;
      this.waiting = [];
      const inside = frame.contentDocument;
      this.scope.postMessage = (data) => {
        const message = new MessageEvent("message", { data });
        this.dispatchEvent(message);
        this.onmessage?.(message);
      };
      this.scope.importScripts = (...scripts) => Promise.all(scripts.map((script) => load(inside, script)));
      load(inside, url).then(() => {
        this.isReady = true;
        this.waiting.splice(0).forEach((data) => this.postMessage(data));
      });
    }

    postMessage(data) {
      if (!this.isReady) {
        this.waiting.push(data);
        return;
      }
      const message = new MessageEvent("message", { data });
      this.scope.dispatchEvent(message);
      this.scope.onmessage?.(message);
    }

    terminate() {
      this.scope.frameElement.remove();
    }
  };
}

function load(inside, url) {
  return new Promise((resolve, reject) => {
    const script = inside.createElement("script");
    script.src = url;
    script.onload = resolve;
    script.onerror = reject;
    inside.documentElement.append(script);
  });
}
