/* ---- kernels: products of four bands ---- */

#if SFIELD__WIDTH > 4
/* Products of 4 bands, which most fields have, without loops: the branches of short loops cost more than the
   arithmetic. Pairs and terms are those of sfield_algebra's tables, in their order, so that the sums have the
   same bits. A change of the tables' order shows in four_bands_have_the_bits_of_the_loops of the tests; the
   lines are then written from pair_i, pair, first and entry of an algebra of 4 bands. */
static inline SFIELD__IN_KERNEL void sfield__pairs4(const float *a, const float *b, size_t stride,
                                                    sfield__lanes *p)
{
    p[0] = sfield__pair(a, b, stride, 1, 1);           p[1] = sfield__pair(a, b, stride, 2, 1);
    p[2] = sfield__pair(a, b, stride, 2, 2);           p[3] = sfield__pair(a, b, stride, 3, 1);
    p[4] = sfield__pair(a, b, stride, 3, 2);          p[5] = sfield__pair(a, b, stride, 3, 3);
    p[6] = sfield__pair(a, b, stride, 4, 1);          p[7] = sfield__pair(a, b, stride, 4, 2);
    p[8] = sfield__pair(a, b, stride, 4, 3);          p[9] = sfield__pair(a, b, stride, 4, 4);
    p[10] = sfield__pair(a, b, stride, 5, 1);         p[11] = sfield__pair(a, b, stride, 5, 2);
    p[12] = sfield__pair(a, b, stride, 5, 3);         p[13] = sfield__pair(a, b, stride, 5, 4);
    p[14] = sfield__pair(a, b, stride, 5, 5);          p[15] = sfield__pair(a, b, stride, 6, 1);
    p[16] = sfield__pair(a, b, stride, 6, 2);         p[17] = sfield__pair(a, b, stride, 6, 3);
    p[18] = sfield__pair(a, b, stride, 6, 4);         p[19] = sfield__pair(a, b, stride, 6, 5);
    p[20] = sfield__pair(a, b, stride, 6, 6);          p[21] = sfield__pair(a, b, stride, 7, 1);
    p[22] = sfield__pair(a, b, stride, 7, 2);         p[23] = sfield__pair(a, b, stride, 7, 3);
    p[24] = sfield__pair(a, b, stride, 7, 4);         p[25] = sfield__pair(a, b, stride, 7, 5);
    p[26] = sfield__pair(a, b, stride, 7, 6);         p[27] = sfield__pair(a, b, stride, 7, 7);
    p[28] = sfield__pair(a, b, stride, 8, 1);         p[29] = sfield__pair(a, b, stride, 8, 2);
    p[30] = sfield__pair(a, b, stride, 8, 3);         p[31] = sfield__pair(a, b, stride, 8, 5);
    p[32] = sfield__pair(a, b, stride, 8, 6);         p[33] = sfield__pair(a, b, stride, 8, 7);
    p[34] = sfield__pair(a, b, stride, 8, 8);          p[35] = sfield__pair(a, b, stride, 9, 1);
    p[36] = sfield__pair(a, b, stride, 9, 3);         p[37] = sfield__pair(a, b, stride, 9, 4);
    p[38] = sfield__pair(a, b, stride, 9, 5);         p[39] = sfield__pair(a, b, stride, 9, 6);
    p[40] = sfield__pair(a, b, stride, 9, 7);         p[41] = sfield__pair(a, b, stride, 9, 8);
    p[42] = sfield__pair(a, b, stride, 9, 9);          p[43] = sfield__pair(a, b, stride, 10, 1);
    p[44] = sfield__pair(a, b, stride, 10, 2);        p[45] = sfield__pair(a, b, stride, 10, 3);
    p[46] = sfield__pair(a, b, stride, 10, 4);        p[47] = sfield__pair(a, b, stride, 10, 5);
    p[48] = sfield__pair(a, b, stride, 10, 7);        p[49] = sfield__pair(a, b, stride, 10, 9);
    p[50] = sfield__pair(a, b, stride, 11, 1);        p[51] = sfield__pair(a, b, stride, 11, 2);
    p[52] = sfield__pair(a, b, stride, 11, 3);        p[53] = sfield__pair(a, b, stride, 11, 4);
    p[54] = sfield__pair(a, b, stride, 11, 5);        p[55] = sfield__pair(a, b, stride, 11, 6);
    p[56] = sfield__pair(a, b, stride, 11, 7);        p[57] = sfield__pair(a, b, stride, 11, 8);
    p[58] = sfield__pair(a, b, stride, 11, 9);        p[59] = sfield__pair(a, b, stride, 11, 10);
    p[60] = sfield__pair(a, b, stride, 11, 11);         p[61] = sfield__pair(a, b, stride, 12, 1);
    p[62] = sfield__pair(a, b, stride, 12, 2);        p[63] = sfield__pair(a, b, stride, 12, 3);
    p[64] = sfield__pair(a, b, stride, 12, 4);        p[65] = sfield__pair(a, b, stride, 12, 5);
    p[66] = sfield__pair(a, b, stride, 12, 6);        p[67] = sfield__pair(a, b, stride, 12, 7);
    p[68] = sfield__pair(a, b, stride, 12, 8);        p[69] = sfield__pair(a, b, stride, 12, 10);
    p[70] = sfield__pair(a, b, stride, 12, 11);       p[71] = sfield__pair(a, b, stride, 12, 12);
    p[72] = sfield__pair(a, b, stride, 13, 1);        p[73] = sfield__pair(a, b, stride, 13, 2);
    p[74] = sfield__pair(a, b, stride, 13, 3);        p[75] = sfield__pair(a, b, stride, 13, 4);
    p[76] = sfield__pair(a, b, stride, 13, 5);        p[77] = sfield__pair(a, b, stride, 13, 6);
    p[78] = sfield__pair(a, b, stride, 13, 7);        p[79] = sfield__pair(a, b, stride, 13, 8);
    p[80] = sfield__pair(a, b, stride, 13, 9);        p[81] = sfield__pair(a, b, stride, 13, 10);
    p[82] = sfield__pair(a, b, stride, 13, 11);       p[83] = sfield__pair(a, b, stride, 13, 12);
    p[84] = sfield__pair(a, b, stride, 13, 13);         p[85] = sfield__pair(a, b, stride, 14, 1);
    p[86] = sfield__pair(a, b, stride, 14, 2);        p[87] = sfield__pair(a, b, stride, 14, 3);
    p[88] = sfield__pair(a, b, stride, 14, 5);        p[89] = sfield__pair(a, b, stride, 14, 7);
    p[90] = sfield__pair(a, b, stride, 14, 8);        p[91] = sfield__pair(a, b, stride, 14, 9);
    p[92] = sfield__pair(a, b, stride, 14, 11);       p[93] = sfield__pair(a, b, stride, 14, 12);
    p[94] = sfield__pair(a, b, stride, 14, 13);       p[95] = sfield__pair(a, b, stride, 15, 1);
    p[96] = sfield__pair(a, b, stride, 15, 3);        p[97] = sfield__pair(a, b, stride, 15, 4);
    p[98] = sfield__pair(a, b, stride, 15, 5);        p[99] = sfield__pair(a, b, stride, 15, 6);
    p[100] = sfield__pair(a, b, stride, 15, 7);       p[101] = sfield__pair(a, b, stride, 15, 8);
    p[102] = sfield__pair(a, b, stride, 15, 10);      p[103] = sfield__pair(a, b, stride, 15, 11);
    p[104] = sfield__pair(a, b, stride, 15, 13);      p[105] = sfield__pair(a, b, stride, 15, 14);
    p[106] = sfield__pair(a, b, stride, 15, 15);
}

static inline SFIELD__IN_KERNEL sfield__lanes sfield__term(const sfield__entry *c, sfield__lanes sum,
                                                           const sfield__lanes *pair)
{
    return sfield__lanes_muladd(sfield__lanes_all(c->c), *pair, sum);
}

static SFIELD__IN_LARGE_KERNEL sfield__lanes sfield__four_terms(const sfield__entry *c, sfield__lanes sum,
                                                                       const sfield__lanes *p,
                                                                       const sfield__lanes *q,
                                                                       const sfield__lanes *s,
                                                                       const sfield__lanes *t)
{
    sum = sfield__term(c, sum, p);
    sum = sfield__term(c + 1, sum, q);
    sum = sfield__term(c + 2, sum, s);
    return sfield__term(c + 3, sum, t);
}

static inline SFIELD__IN_KERNEL void sfield__terms4(const sfield__entry *c, const sfield__lanes *p,
                                                    sfield__lanes *r)
{
    r[1] = sfield__four_terms(c + 0, r[1], &p[8], &p[11], &p[15], &p[28]);
    r[1] = sfield__four_terms(c + 4, r[1], &p[41], &p[48], &p[55], &p[57]);
    r[1] = sfield__four_terms(c + 8, r[1], &p[65], &p[75], &p[88], &p[97]);
    r[2] = sfield__four_terms(c + 12, r[2], &p[10], &p[16], &p[23], &p[46]);
    r[2] = sfield__four_terms(c + 16, r[2], &p[54], &p[66], &p[78], &p[90]);
    r[3] = sfield__four_terms(c + 20, r[3], &p[6], &p[17], &p[22], &p[30]);
    r[3] = sfield__four_terms(c + 24, r[3], &p[37], &p[47], &p[53], &p[67]);
    r[3] = sfield__four_terms(c + 28, r[3], &p[77], &p[79], &p[89], &p[101]);
    r[4] = sfield__four_terms(c + 32, r[4], &p[3], &p[18], &p[25], &p[36]);
    r[4] = sfield__four_terms(c + 36, r[4], &p[44], &p[52], &p[69], &p[72]);
    r[4] = sfield__four_terms(c + 40, r[4], &p[80], &p[82], &p[95], &p[103]);
    r[5] = sfield__four_terms(c + 44, r[5], &p[1], &p[19], &p[24], &p[31]);
    r[5] = sfield__four_terms(c + 48, r[5], &p[45], &p[51], &p[61], &p[70]);
    r[5] = sfield__four_terms(c + 52, r[5], &p[81], &p[85], &p[91], &p[92]);
    r[5] = sfield__term(c + 56, r[5], &p[102]);
    r[6] = sfield__four_terms(c + 57, r[6], &p[0], &p[2], &p[5], &p[9]);
    r[6] = sfield__four_terms(c + 61, r[6], &p[14], &p[20], &p[27], &p[34]);
    r[6] = sfield__four_terms(c + 65, r[6], &p[42], &p[50], &p[60], &p[62]);
    r[6] = sfield__four_terms(c + 69, r[6], &p[71], &p[74], &p[84], &p[106]);
    r[7] = sfield__four_terms(c + 73, r[7], &p[4], &p[13], &p[26], &p[33]);
    r[7] = sfield__four_terms(c + 77, r[7], &p[43], &p[49], &p[59], &p[63]);
    r[7] = sfield__four_terms(c + 81, r[7], &p[73], &p[83], &p[87], &p[94]);
    r[7] = sfield__term(c + 85, r[7], &p[105]);
    r[8] = sfield__four_terms(c + 86, r[8], &p[0], &p[5], &p[14], &p[27]);
    r[8] = sfield__four_terms(c + 90, r[8], &p[32], &p[35], &p[50], &p[58]);
    r[8] = sfield__four_terms(c + 94, r[8], &p[60], &p[74], &p[84], &p[86]);
    r[8] = sfield__term(c + 98, r[8], &p[93]);
    r[8] = sfield__term(c + 99, r[8], &p[96]);
    r[8] = sfield__term(c + 100, r[8], &p[104]);
    r[9] = sfield__four_terms(c + 101, r[9], &p[8], &p[28], &p[39], &p[48]);
    r[9] = sfield__term(c + 105, r[9], &p[57]);
    r[9] = sfield__term(c + 106, r[9], &p[75]);
    r[9] = sfield__term(c + 107, r[9], &p[88]);
    r[10] = sfield__four_terms(c + 108, r[10], &p[7], &p[12], &p[21], &p[40]);
    r[10] = sfield__four_terms(c + 112, r[10], &p[56], &p[64], &p[76], &p[98]);
    r[11] = sfield__four_terms(c + 116, r[11], &p[8], &p[11], &p[15], &p[28]);
    r[11] = sfield__four_terms(c + 120, r[11], &p[41], &p[48], &p[55], &p[57]);
    r[11] = sfield__four_terms(c + 124, r[11], &p[65], &p[75], &p[88], &p[97]);
    r[12] = sfield__four_terms(c + 128, r[12], &p[10], &p[16], &p[23], &p[46]);
    r[12] = sfield__four_terms(c + 132, r[12], &p[54], &p[66], &p[78], &p[90]);
    r[13] = sfield__four_terms(c + 136, r[13], &p[6], &p[17], &p[22], &p[30]);
    r[13] = sfield__four_terms(c + 140, r[13], &p[37], &p[47], &p[53], &p[67]);
    r[13] = sfield__four_terms(c + 144, r[13], &p[77], &p[79], &p[89], &p[101]);
    r[14] = sfield__four_terms(c + 148, r[14], &p[10], &p[23], &p[29], &p[38]);
    r[14] = sfield__four_terms(c + 152, r[14], &p[54], &p[68], &p[78], &p[100]);
    r[15] = sfield__four_terms(c + 156, r[15], &p[6], &p[30], &p[47], &p[53]);
    r[15] = sfield__term(c + 160, r[15], &p[79]);
    r[15] = sfield__term(c + 161, r[15], &p[89]);
    r[15] = sfield__term(c + 162, r[15], &p[99]);
}

SFIELD__KERNEL static void sfield__product4(const sfield_algebra *t, const float *a, const float *b,
                                            float *out, size_t stride, int occlude)
{
    sfield__lanes p[107], r[16];
    sfield__product_begin(a, b, stride, 16, r);
    sfield__pairs4(a, b, stride, p);
    sfield__terms4(t->entry, p, r);
    sfield__product_end(a, stride, 16, occlude, r, out);
}
#endif
