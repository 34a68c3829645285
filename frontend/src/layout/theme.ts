import {
  Badge,
  type CSSVariablesResolver,
  createTheme,
  type MantineColorsTuple,
  Notification,
  SegmentedControl,
  Tooltip,
} from "@mantine/core";

// Mantine's own, but for the last shade: white text can be read on it, and it can be read on the first one.
const green: MantineColorsTuple = [
  "#ebfbee",
  "#d3f9d8",
  "#b2f2bb",
  "#8ce99a",
  "#69db7c",
  "#51cf66",
  "#40c057",
  "#37b24d",
  "#2f9e44",
  "#237032",
];

const orange: MantineColorsTuple = [
  "#fff4e6",
  "#ffe8cc",
  "#ffd8a8",
  "#ffc078",
  "#ffa94d",
  "#ff922b",
  "#fd7e14",
  "#f76707",
  "#e8590c",
  "#a33a00",
];

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
  colors: { green, orange },
  autoContrast: true,
  respectReducedMotion: true,
  cursorType: "pointer",
  fontFamily: "system-ui, -apple-system, 'Segoe UI', Roboto, 'Noto Sans', 'DejaVu Sans', sans-serif",
  fontFamilyMonospace: "ui-monospace, 'SF Mono', Menlo, Consolas, 'DejaVu Sans Mono', monospace",
  components: {
    Badge: Badge.extend({ defaultProps: { size: "lg", tt: "none", fw: 600 } }),
    Notification: Notification.extend({ styles: { description: { color: "var(--mantine-color-dimmed)" } } }),
    SegmentedControl: SegmentedControl.extend({ defaultProps: { size: "sm" } }),
    Tooltip: Tooltip.extend({ defaultProps: { events: { hover: true, focus: true, touch: true } } }),
  },
});
