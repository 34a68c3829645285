"""Files of pictures as cameras send them: JPEGs of several kinds, and a PNG with any filters."""

import base64
import struct
import zlib
from collections.abc import Sequence

import numpy as np
import simplejpeg

# A gradient of 32 x 24 pixels, with ten scans.
PROGRESSIVE = base64.b85decode(
    "|JeWF01!$>Nk#wx0RR9200961|JwjV01XKW3knDg3knMk4h;_zAQcl55)&sJ9v2`kDKRiEDJ?8BI!Zn>HbyrrEkIX6ModmpQ&KWMT47pHU`kO^"
    "PygEhLjevB4iga*CKVMXPc<zyPft%zPft%zPft%zPft%zPft%zPft%zPft%zPft%zPft%zPft%zPft%zPft%zPf!2C01*fP7yuvx0U`hb5di}c"
    "0sq7R7XSeP0RaF20000000000000931O@-Z02cuP0RaI30000000000000021q25F+5ij#0RRFJ0}ucJ0pPxuCo}1HL|(J=uJq`C|HJ?m5C8)J"
    "00000000000000000033|Jncu0RaF31p-hg6bc0bfk2>8C=?10|HJ?n5di@K0RR91000000000000RI40{_|o2mu2D0Y3pIiK6Rb>u>+W02L7d"
    "0RR910000000000000010RP$m2mt~C0Y3p4VlV&102B}b0000000000000000000m|Jncu0RaF8KLStx!~hf!0RR91000000000000000F#p;B"
    "2mt{A0Y4#1s;aO5+5ij#0RRF30{{R35X&#W|HJ?k5di=I00000000000000003iR`00;pC0RcY{0GI#702UDe0RaF200000000000000101*G$"
    "00;pB0RcY{#Y~(3!~hi#0RaF20000000000000000Ac^y00;pA00BP`f(Rgj2q1z8Aph9"
)
# The same with a restart marker after each block.
RESTARTING = base64.b85decode(
    "|JeWF01!$>Nk#wx0RR9200961|JwjV01XKW3knDg3knMk4h;_zAQcl55)&sJ9v2`kDKRiEDJ?8BI!Zn>HbyrrEkIX6ModmpQ&KWMT47pHU`kO^"
    "PygEhLjevB4iga*CKVMXPc<zyPft%zPft%zPft%zPft%zPft%zPft%zPft%zPft%zPft%zPft%zPft%zPft%zPf!2A01*fP7yuvx0U`hb5di}c"
    "0sq7R9{>OW1pxs80RaI300000000010s{mE1_uZU3Jd?l0JRVR0s#X90t5pE1q1{D00Dgg0s{a95d{(<F+m0sQDFxnaTGFvk)a49Lb1UWQqk}v"
    "Gh%Xr2?`b$7#SKRCMPH<Dl|1VH#j*uLqtVJM@UIZQ&d$}S6EqEV`OD!XJ~0^b98lfcX)YvgM@{Khlq)al9QB`mY0~BnxdnmrKYE-sj9NGw6(Uk"
    "xVgH*!^FkL$H>Xb($mz{*4NnC+Tr5k<mKk)=;`Y5^7Hid_V@Vt`v1fL9{~UZ0RaI40RaI40RR91000010s{mE1_uZU3Jd?l0JRYS0s#U91Oo&I"
    "1q1{D0Rndb0RjUN1O*{61`<J02Vrp&A~Jyp6he`qvB3!=Gg9ysVsg<679=#`CGi&+85$-hC@Cs6Ha9pqIzvQ7Mn_0VN>fx-R##YAT4Q8oW@l(="
    "YIAgTc6WGrdV+(5g@%WSiHeewl$Dm3n3<ZQqok##r>Lo_va__cwzs&sy28W6#m2|T$;#5x)YaD4*xB0R<K*S$=jiF`^7Hid_V@Vt`v2Vk1ONg5"
    "+5ij#0RRFK0}%i}0O29C_N&m@`&NuLe${##KWd1~&kKw{|IomO&)Tm;XYE=r+51)KZ2hX^Gv31E5C748Hh$H58$W6&t|+#A&K9hX|I*)v&)Tm;"
    "XYEB5gj+Jg)sg?%"
)
GRADIENT = np.ascontiguousarray(np.dstack([np.tile(np.arange(160, dtype=np.uint8), (90, 1))] * 3))
BASELINE = simplejpeg.encode_jpeg(GRADIENT)
GRAY = simplejpeg.encode_jpeg(np.ascontiguousarray(GRADIENT[:, :, :1]), 80, "GRAY", "Gray")


def with_thumbnail(jpeg: bytes, thumbnail: bytes = BASELINE) -> bytes:
    """A JPEG whose EXIF holds another one."""
    exif = b"Exif\0\0" + thumbnail
    return jpeg[:2] + b"\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif + jpeg[2:]


def with_fill_bytes(jpeg: bytes) -> bytes:
    """A JPEG with three more FF before its second marker and before its end."""
    return jpeg[:2] + b"\xff\xff\xff" + jpeg[2:-2] + b"\xff\xff\xff" + jpeg[-2:]


def encode_png(rows: np.ndarray, filters: Sequence[int] = (0,)) -> bytes:
    """A PNG of grey: of rows of numbers, each with the next of the filters.

    Args:
        rows: Of 8 or 16 bits.
        filters: 0 to 4.
    """
    height, width = rows.shape
    depth = rows.dtype.itemsize
    lines = rows.astype(rows.dtype.newbyteorder(">")).view(np.uint8).reshape(height, width * depth).astype(int)
    above, packed = np.zeros(width * depth, int), b""
    for index, line in enumerate(lines):
        left, corner = (np.concatenate((np.zeros(depth, int), each[:-depth])) for each in (line, above))
        guess = left + above - corner
        to_left, to_above, to_corner = (abs(guess - each) for each in (left, above, corner))
        paeth = np.where(
            (to_left <= to_above) & (to_left <= to_corner), left, np.where(to_above <= to_corner, above, corner)
        )
        kind = filters[index % len(filters)]
        predicted = (0, left, above, (left + above) // 2, paeth)[kind]
        packed += bytes([kind]) + ((line - predicted) % 256).astype(np.uint8).tobytes()
        above = line
    header = struct.pack(">IIBBBBB", width, height, 8 * depth, 0, 0, 0, 0)
    data = zlib.compress(packed)
    chunks = ((b"IHDR", header), (b"IDAT", data[:9]), (b"IDAT", data[9:]), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(chunk(*each) for each in chunks)


def chunk(kind: bytes, content: bytes) -> bytes:
    """A part of a PNG."""
    return struct.pack(">I", len(content)) + kind + content + struct.pack(">I", zlib.crc32(kind + content))
