import { type UseMutationResult, useMutation } from "@tanstack/react-query";
import { type CommandError, toCommandError } from "../api/errors";

/** A command to the gateway, sent once for each call and never again by itself. */
export function useCommand<Result, Input = void>(
  send: (input: Input) => Promise<Result>,
): UseMutationResult<Result, CommandError, Input> {
  return useMutation<Result, CommandError, Input>({
    // By default a mutation made while the browser is offline waits, and is sent when it is back.
    networkMode: "always",
    retry: false,
    mutationFn: (input) =>
      send(input).catch((error: unknown) => {
        throw toCommandError(error);
      }),
  });
}
