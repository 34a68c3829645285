import { type ComponentType, lazy } from "react";

const RETRY_MS = 2000;

/**
 * A part of the page whose code is loaded when it is first shown. If the gateway does not answer then, it is loaded as
 * soon as it does.
 *
 * An error is thrown where the gateway answers and the code is not there, as after an update; `Guarded` shows it.
 */
export function lazyPart<Props>(load: () => Promise<{ default: ComponentType<Props> }>) {
  return lazy(() => load().catch(() => gatewayAnswers().then(load)));
}

async function gatewayAnswers(): Promise<void> {
  while (!(await fetch("/healthz").catch(() => null))?.ok) {
    await new Promise((resolve) => setTimeout(resolve, RETRY_MS));
  }
}
