// Recording a clip of a canvas.

/** Container and codecs in order of preference. */
const TYPES = ["video/webm;codecs=vp9,opus", "video/webm", "video/mp4"];
const BITS_PER_SECOND = 12e6;
/** A canvas that does not change is recorded only if it is painted again. */
const REPAINT_MS = 40;

/**
 * Starts to record a canvas with the sound of a film; returns null if the browser cannot.
 * @param {import("./styled_canvas.js").StyledCanvas} styled
 * @param {HTMLVideoElement | null} video a film or camera
 * @param {object} events
 * @param {(seconds: number) => void} events.ontime is called with the length so far
 * @param {(clip: Blob, extension: string) => void} events.onend is called when it is stopped
 * @returns {MediaRecorder | null}
 */
export function record(styled, video, { ontime, onend }) {
  const type = TYPES.find((each) => window.MediaRecorder?.isTypeSupported(each));
  if (!type) return null;
  const stream = styled.canvas.captureStream();
  // Not every browser has captureStream of a film.
  const film = /** @type {HTMLVideoElement & {captureStream?: () => MediaStream} | null} */ (video);
  const heard = film?.srcObject ?? film?.captureStream?.();
  for (const track of heard instanceof MediaStream ? heard.getAudioTracks() : []) stream.addTrack(track);
  /** @type {Blob[]} */
  const parts = [];
  const recorder = new MediaRecorder(stream, { mimeType: type, videoBitsPerSecond: BITS_PER_SECOND });
  recorder.addEventListener("dataavailable", (event) => parts.push(event.data));
  const began = performance.now();
  const timer = setInterval(() => {
    styled.compose();
    ontime((performance.now() - began) / 1000);
  }, REPAINT_MS);
  recorder.addEventListener("stop", () => {
    clearInterval(timer);
    onend(new Blob(parts, { type }), type.includes("mp4") ? "mp4" : "webm");
  });
  recorder.start(1000);
  return recorder;
}
