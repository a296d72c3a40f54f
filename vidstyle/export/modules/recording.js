// Recording a clip of a canvas.

/** Container and codecs in order of preference. */
const TYPES = ["video/webm;codecs=vp9,opus", "video/webm", "video/mp4"];
const BITS_PER_SECOND = 12e6;

/**
 * Starts to record a canvas with the sound of a film; returns null if the browser cannot.
 * @param {HTMLCanvasElement} canvas
 * @param {HTMLVideoElement | null} video a film or camera
 * @param {(clip: Blob, extension: string) => void} onend is called when it is stopped
 * @returns {MediaRecorder | null}
 */
export function record(canvas, video, onend) {
  const type = TYPES.find((each) => window.MediaRecorder?.isTypeSupported(each));
  if (!type) return null;
  const stream = canvas.captureStream();
  // Not every browser has captureStream of a film.
  const film = /** @type {HTMLVideoElement & {captureStream?: () => MediaStream} | null} */ (video);
  const heard = film?.srcObject ?? film?.captureStream?.();
  for (const track of heard instanceof MediaStream ? heard.getAudioTracks() : []) stream.addTrack(track);
  /** @type {Blob[]} */
  const parts = [];
  const recorder = new MediaRecorder(stream, { mimeType: type, videoBitsPerSecond: BITS_PER_SECOND });
  recorder.addEventListener("dataavailable", (event) => parts.push(event.data));
  recorder.addEventListener("stop", () => onend(new Blob(parts, { type }), type.includes("mp4") ? "mp4" : "webm"));
  recorder.start(1000);
  return recorder;
}
