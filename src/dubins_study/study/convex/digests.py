"""SHA-256 of the files of `problems`; written by `benchmarks.freeze_convex`."""

DIGESTS = {
    "trivial": "92d5a6e8694a1326388a49ac2fcfff8ddd26a51816bc6c0d8624b3029ee2c7bb",
    "qp-50-well": "295b44afa1b658ad545e5df0b8d5470f412b820c35df9232bb1fdb872e1c7f0e",
    "qp-50-bad": "0ee22dce7e8f4a0a873d26e0a0aac8ffbd9736c3a3c6c3b31810edd905785e6c",
    "qp-500-well": "8a3cf08ec451b56a505a09c11898c58183449264fbdf6f35b58f310c3c21f33b",
    "qp-500-bad": "e6ddb5d0f998a1e5ab736312f18c703dfc9d36337ad6dc8216507de379fda52c",
    "qp-5000-well": "7d252194bf95a8602cac3e484a5f5fd0ac1652efe79a1168df7128eb1bf2f07d",
    "qp-5000-bad": "e70a0b3ba8563abd2904c46bb162344cf4f432bd401b581c9ea079c39f6915f6",
    "socp-50-well": "946610ec7089d411ec07aa3657bec02ec5a2cd577cb0fe8b8ded35834554d4c4",
    "socp-50-bad": "e6a1682deebe5be5b6eb261a5eef6c6fa24332f8a33471ccddce606370e853f6",
    "socp-500-well": "fb88695d40da75022dd365433c13a5269b7cfade496029507ede113d1517e1d8",
    "socp-500-bad": "cd2267c27aeedab2fdcc756a3bd4b50e84aa20fff35a2195ecbbf6f964e2dd3a",
    "socp-5000-well": "50f5a0f135e78ab64680f406d5917ab7f51f6bb1ad24a0e76e1b6bb254de23c3",
    "socp-5000-bad": "d671bdb37227ef661a0110fed779f5a838c02e86ea63fe54426dd59779de5888",
}
