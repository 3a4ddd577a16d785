// Opens the trace of the run in Perfetto, in a window of its own: asks that window until it answers, then
// sends it the trace. Perfetto's documentation calls this deep linking.
(() => {
  "use strict";
  const ASK_MS = 100;
  const LIMIT_MS = 60000;
  const $ = (id) => document.getElementById(id);
  const button = $("perfetto");
  const say = (text) => { $("perfetto-said").textContent = text; };

  /** The trace: out of this page, or out of the file that was chosen. */
  async function trace() {
    const file = $("trace-file");
    if (file) return file.files[0].arrayBuffer();
    const packed = Uint8Array.from(atob($("trace-data").textContent), (c) => c.charCodeAt(0));
    const plain = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Response(plain).arrayBuffer();
  }

  /** True once the window answers, false when it does not or is closed. */
  function answers(other, origin) {
    return new Promise((done) => {
      const began_ms = performance.now();
      const hear = (event) => {
        if (event.source === other && event.origin === origin && event.data === "PONG") end(true);
      };
      const timer = setInterval(() => {
        if (other.closed || performance.now() - began_ms > LIMIT_MS) end(false);
        // Until it has loaded, the window has another origin. There is nothing to hide in this word.
        else other.postMessage("PING", "*");
      }, ASK_MS);
      const end = (answered) => {
        clearInterval(timer);
        removeEventListener("message", hear);
        done(answered);
      };
      addEventListener("message", hear);
    });
  }

  button.addEventListener("click", async () => {
    if ($("trace-file") && !$("trace-file").files.length) return say("Choose the file first.");
    const { page, title } = button.dataset;
    const { origin } = new URL(page);
    const other = window.open(page);
    if (!other) return say("The browser has blocked the window.");
    say("Perfetto is loading …");
    try {
      const [buffer, answered] = await Promise.all([trace(), answers(other, origin)]);
      if (!answered) return say("Perfetto does not answer. The file beside this page opens in it, too.");
      other.postMessage({ perfetto: { buffer, title, fileName: "trace.json" } }, origin);
      say("The trace is in Perfetto's window.");
    } catch (error) {
      say(`The trace cannot be read: ${error.message}`);
    }
  });
})();
