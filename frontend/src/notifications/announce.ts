/** Sounds and notifications of the operating system, where the browser allows them. */

export interface Announcement {
  /** One with the same tag replaces an earlier one, also from another tab. */
  tag: string;
  title: string;
  body: string;
  critical: boolean;
  onPress: () => void;
}

/** How long it is waited for the browser to allow a sound (ms). Later it would only startle. */
const SOUND_WITHIN_MS = 1000;
let audio: AudioContext | null = null;

/** Two notes for what is critical, one for the rest. Silent until somebody has pressed something on the page. */
export async function playSound(critical: boolean): Promise<void> {
  audio ??= new AudioContext();
  const context = audio;
  await Promise.race([context.resume(), new Promise((resolve) => setTimeout(resolve, SOUND_WITHIN_MS))]);
  if (context.state !== "running") return;
  const notes = critical ? [880, 660] : [660];
  notes.forEach((frequency, index) => {
    playNote(context, frequency, context.currentTime + 0.25 * index);
  });
}

function playNote(context: AudioContext, frequency: number, begin: number): void {
  const tone = new OscillatorNode(context, { frequency });
  const volume = new GainNode(context, { gain: 0 });
  volume.gain.setTargetAtTime(0.3, begin, 0.01);
  volume.gain.setTargetAtTime(0, begin + 0.15, 0.05);
  tone.connect(volume).connect(context.destination);
  tone.start(begin);
  tone.stop(begin + 0.5);
}

/** Why there can be no notifications; null where there can be. */
export function whyNoNotifications(): string | null {
  if (!window.isSecureContext)
    return "The browser shows notifications only over HTTPS, or on the gateway's own computer.";
  if (!("Notification" in window)) return "This browser has no notifications.";
  if (Notification.permission === "denied")
    return "Notifications are blocked for this page in the browser's settings.";
  return null;
}

/** Asks the reader; whether they are allowed. */
export async function allowNotifications(): Promise<boolean> {
  return whyNoNotifications() === null && (await Notification.requestPermission()) === "granted";
}

export function notify({ tag, title, body, critical, onPress }: Announcement): void {
  if (whyNoNotifications() !== null || Notification.permission !== "granted") return;
  try {
    const shown = new Notification(title, { body, tag, requireInteraction: critical });
    shown.onclick = () => {
      window.focus();
      shown.close();
      onPress();
    };
  } catch {
    // On Android a page cannot show one.
  }
}
