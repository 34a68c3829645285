import { useLocalStorage } from "@mantine/hooks";

const KEY = "dock-gateway-unasked-actions";

export interface Asking {
  /** Whether it is asked before a goal is sent. */
  asks: boolean;
  /** Goals of this type move nothing, so that it is never asked: Fibonacci only counts. */
  harmless: boolean;
  change: (asks: boolean) => void;
}

/** Whether to ask before a goal is sent to an action: until somebody switches that off for it, in this browser. */
export function useAsking(action: string, type: string): Asking {
  const [unasked, setUnasked] = useLocalStorage<readonly string[]>({
    key: KEY,
    defaultValue: [],
    getInitialValueInEffect: false,
  });
  const harmless = type.endsWith("/action/Fibonacci");
  return {
    asks: !harmless && !unasked.includes(action),
    harmless,
    change: (asks) =>
      setUnasked((before) => [...before.filter((each) => each !== action), ...(asks ? [] : [action])]),
  };
}
