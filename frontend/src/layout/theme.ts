import {
  Badge,
  type CSSVariablesResolver,
  createTheme,
  Notification,
  SegmentedControl,
  Tooltip,
} from "@mantine/core";
import { FONT, GREEN, MONOSPACE, ORANGE } from "../ui/tokens";

/** The colours of quiet text and of errors and, in the dark, those of outlines, which are too faint by default. */
export const cssVariables: CSSVariablesResolver = (base) => ({
  variables: {},
  light: {
    "--mantine-color-dimmed": base.colors.gray[7],
    "--mantine-color-placeholder": base.colors.gray[6],
    "--mantine-color-error": base.colors.red[9],
  },
  dark: {
    "--mantine-color-dimmed": base.colors.dark[1],
    "--mantine-color-placeholder": base.colors.dark[2],
    "--mantine-color-error": base.colors.red[4],
    "--mantine-color-blue-outline": base.colors.blue[3],
    "--mantine-color-grape-outline": base.colors.grape[3],
  },
});

/** Mantine's defaults miss WCAG's contrast in places; these do not. */
export const theme = createTheme({
  primaryColor: "blue",
  primaryShade: 9,
  colors: { green: GREEN, orange: ORANGE },
  autoContrast: true,
  respectReducedMotion: true,
  cursorType: "pointer",
  fontFamily: FONT,
  fontFamilyMonospace: MONOSPACE,
  components: {
    Badge: Badge.extend({ defaultProps: { size: "lg", tt: "none", fw: 600 } }),
    Notification: Notification.extend({ styles: { description: { color: "var(--mantine-color-dimmed)" } } }),
    SegmentedControl: SegmentedControl.extend({ defaultProps: { size: "sm" } }),
    Tooltip: Tooltip.extend({ defaultProps: { events: { hover: true, focus: true, touch: true } } }),
  },
});
