// table - where texel i of a table stands: 1024 wide, 1024 high, then layers (glbk__table_create).
ivec3 glbk_table_at(uint i)
{
    return ivec3(uvec3(i & 1023u, i >> 10 & 1023u, i >> 20));
}
