import { type ComponentType, lazy } from "react";

const ANSWER_MS = 10_000;
const RETRY_MS = 2000;

/**
 * A part of the page whose code is loaded when it is first shown, as soon as the gateway answers.
 *
 * If the gateway leaves while the code is loaded, the page is loaded again when it is back: not every browser asks again
 * for a file that it could not load, and Vite does not for stylesheets. An error is thrown where the gateway answers
 * and the code is not there, as after an update; `Guarded` shows it.
 */
export function lazyPart<Props>(load: () => Promise<{ default: ComponentType<Props> }>) {
  return lazy(async () => {
    await gatewayAnswers();
    try {
      return await load();
    } catch (error) {
      if (await answers()) throw error;
    }
    await gatewayAnswers();
    window.location.reload();
    return new Promise<never>(() => {}); // until the page is gone
  });
}

async function gatewayAnswers(): Promise<void> {
  while (!(await answers())) {
    await new Promise((resolve) => setTimeout(resolve, RETRY_MS));
  }
}

async function answers(): Promise<boolean> {
  const signal = AbortSignal.timeout(ANSWER_MS);
  return fetch("/healthz", { signal }).then(
    // Without ROS the gateway answers 503, and serves its files all the same; a proxy's 503 is a page.
    ({ ok, headers }) => ok || headers.get("content-type")?.startsWith("application/json") === true,
    () => false,
  );
}
